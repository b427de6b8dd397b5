"""An optimisation as a source of cases: Optuna's samplers, asked and told in an order that depends on no worker.

The sampler chooses case n by the results of the cases 1 to n - `parallel`, told in their order, and by nothing else:
however many workers there are, and whichever ends first, the cases are the same for the same seed. What the sampler
knows is not stored: it follows from the rows, so that an optimisation goes on where it was.
"""

import difflib
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

from pipeline.errors import UsageError
from pipeline.study.cases import Case, Cases
from pipeline.study.config import Kind, Sampler, StudyConfig
from pipeline.study.engine import Fixed, Source
from pipeline.study.extra import library
from pipeline.study.optimise.space import choice_of, distributions, point_of
from pipeline.study.rows import Ending, Row
from pipeline.study.store import Store
from pipeline.study.verdict import number, violation

_SUGGESTED = 3


@dataclass
class Optimiser:
    """Cases chosen by the results of those before: first the configuration as it is, where the ranges allow it.

    Attributes
    ----------
    cases : Cases
        The study, and how its points become cases.
    strict : bool
        Refuse figures that the first run with a result does not have: they are misspelt, or of a later stage.
    """

    cases: Cases
    strict: bool = True
    _sampler: Any = field(init=False)
    _trials: dict[int, Any] = field(default_factory=dict, init=False)
    _rows: dict[int, Row] = field(default_factory=dict, init=False)
    _found: bool = field(default=False, init=False)
    _running: dict[str, list[Case]] = field(default_factory=dict, init=False)
    _ready: list[Case] = field(default_factory=list, init=False)
    _asked: int = field(default=0, init=False)
    _told: int = field(default=0, init=False)

    def __post_init__(self) -> None:
        study = self.cases.study
        self._sampler = _begin(study)
        first = choice_of(study, self.cases.base)
        if first is not None:
            self._sampler.enqueue_trial(first)

    def ask(self) -> Case | None:
        """Give the next case; None if there is none, or none before an earlier one has ended."""
        if self._ready:
            return self._ready.pop(0)
        while self._asked < len(self.cases) and self._catch_up():
            case = self._next()
            if case.key not in self._running:
                self._running[case.key] = []
                return case
            # The sampler has chosen a point again that is being run.
            self._running[case.key].append(case)
        return None

    def tell(self, case: Case, row: Row) -> None:
        """Take the row of a case; the sampler has it when those before it have ended, too.

        Raises
        ------
        UsageError
            When the run has a result, and not the figures that are optimised.
        """
        if row.ending == Ending.DONE and not self._found:
            self._found = True
            if self.strict:
                self._require_figures(row)
        self._rows[case.number] = row
        self._ready += self._running.pop(case.key, [])

    def _catch_up(self) -> bool:
        """Tell the sampler what it has to know for the next case; False if that is not known yet."""
        while self._told < self._asked + 1 - self.cases.study.design.parallel:
            if self._told + 1 not in self._rows:
                return False
            self._told += 1
            self._tell_sampler(self._trials.pop(self._told), self._rows.pop(self._told))
        return True

    def _tell_sampler(self, trial: Any, row: Row) -> None:
        study = self.cases.study
        excess = violation(study, row)
        trial.set_constraint("violation", excess)
        # Of a trial that breaks a constraint samplers use nothing but by how much.
        values = [0.0 if excess else number(row.figures, name.removeprefix("-")) for name in study.pareto]
        self._sampler.tell(trial, values)

    def _next(self) -> Case:
        self._asked += 1
        trial = self._sampler.ask(distributions(self.cases.study))
        self._trials[self._asked] = trial
        return self.cases.case(self._asked, point_of(self.cases.study, trial.params))

    def _require_figures(self, row: Row) -> None:
        study = self.cases.study
        wanted = [(f"pareto[{k}]", name.removeprefix("-")) for k, name in enumerate(study.pareto)]
        wanted += [(f"constraints[{k}].figure", one.figure) for k, one in enumerate(study.constraints)]
        for place, name in wanted:
            if number(row.figures, name) is None:
                known = [path for path in row.figures if number(row.figures, path) is not None]
                near = difflib.get_close_matches(name, known, n=_SUGGESTED, cutoff=0.5)
                hint = f"near it are {', '.join(near)}" if near else f"runs end after {study.to}"
                raise UsageError(
                    f"{place}: a run has a result, and no number {name}: {hint}.\n"
                    "  What to change: correct the figure, or let runs go further (to), and give the same command: "
                    "what is done is kept."
                )


def source_of(cases: Cases, strict: bool = True) -> Source:
    """Give the source of a study's cases: its design, or an optimiser."""
    return Optimiser(cases, strict) if cases.study.design.kind is Kind.OPTIMISE else Fixed(iter(cases))


def ended_cases(cases: Cases, store: Store) -> Iterator[tuple[Case, Row]]:
    """Give the cases of a study that have ended, each with its row."""
    source = source_of(cases, strict=False)
    while (case := source.ask()) is not None:
        row = store.row(case.key)
        if row is not None:
            source.tell(case, row)
            yield case, row


def _begin(study: StudyConfig) -> Any:
    """Begin a study of Optuna's in memory."""
    design = study.design
    optuna = library("optuna")
    optuna.logging.set_verbosity(optuna.logging.WARNING)
    if design.sampler is Sampler.NSGA2:
        sampler = optuna.samplers.NSGAIISampler(population_size=design.initial, seed=design.seed)
    else:
        sampler = optuna.samplers.TPESampler(n_startup_trials=design.initial, seed=design.seed)
    directions = ["maximize" if name.startswith("-") else "minimize" for name in study.pareto]
    return optuna.create_study(sampler=sampler, directions=directions)
