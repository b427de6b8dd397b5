"""The stages of a run, one row each: what is known of a stage, and where its code is.

A new stage is a member of `Stage`, a row here, and the modules that the row names, with their tests.
"""

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from typing import TYPE_CHECKING, Any

from pipeline.artifacts.layout import (
    BACK_CSV,
    BACK_JSON,
    CALIBRATION_JSON,
    CERTIFICATE_JSON,
    CORRECTION_CSV,
    FIGURE_PATTERNS,
    FIGURES,
    FOLLOWING_CSV,
    PATH_CSV,
    PATH_NPZ,
    POSE_ERROR_CSV,
    POSE_ERROR_NPZ,
    REGIONS_NPZ,
    REPORT,
    ROUTE_CSV,
    ROUTE_NPZ,
    TRAJECTORY_CSV,
    TRAJECTORY_JSON,
    TRAJECTORY_NPZ,
    failure_files_of,
)
from pipeline.config import Config
from pipeline.run.config_parts import (
    certify_part,
    refine_part,
    regions_part,
    retime_part,
    route_part,
    whole_config,
    with_sufficient_proofs,
)
from pipeline.stage import STAGES, Stage
from pipeline.summary.section import Section, own_or_skipped

if TYPE_CHECKING:
    from pipeline.artifacts import State
    from pipeline.errors import NoSolutionError
    from pipeline.progress import Monitor
    from pipeline.run.diagnosis import Diagnosis
    from pipeline.run.product import Product
    from pipeline.run.results import Results


@dataclass(frozen=True)
class Deferred:
    """A function by its module and name, imported when it is first called: solvers and plotting load slowly."""

    module: str
    name: str

    def __call__(self, *arguments: Any) -> Any:
        """Call the function."""
        return getattr(import_module(self.module), self.name)(*arguments)


def _itself(config: Config) -> tuple[Config, ...]:
    return (config,)


def _nothing(section: Section) -> None:
    return None


@dataclass(frozen=True)
class StageSpec:
    """What is known of a stage.

    Attributes
    ----------
    stage : Stage
        The stage.
    upstream : tuple of Stage
        The stages whose results it is given.
    completes : tuple of Stage
        Earlier stages whose files it completes; its own result does not depend on them.
    config_part : callable
        Gives the keys of the configuration that it may read.
    make : callable
        Computes its result, files and part of the summary.
    load : callable or None
        Loads its result back from a run folder; None if no stage is given it.
    result : str
        The file that its result is loaded from; empty if there is none.
    files : tuple of str
        All files it may write, as patterns.
    section : str
        Where its part is in `summary.json`.
    words : callable
        Says the key figures of that part in words.
    shown : tuple
        Files worth opening afterwards, and what they are.
    next_step : str
        What to do after a run that ends here; `{config}`, `{out}` (an option), `{folder}`, `{report}` are filled in.
    sufficient : callable
        Gives the configurations whose results are good enough for one.
    in_summary : callable
        Makes the part of the summary from a section, or from None if there is no result.
    quotes_upstream : bool
        Whether its files quote the parts of the summary of earlier stages.
    withheld : callable
        Gives the error with which a run stops at a result, complete but not to be used unasked; None: it goes on.
    explain : callable or None
        Finds out why there is no solution, where that is proven.
    report : callable or None
        Makes a report from the results so far.
    beside : tuple of Stage
        The stages beside which a second process already makes a part of it.
    """

    stage: Stage
    upstream: tuple[Stage, ...]
    config_part: Callable[[Config], dict[str, Any]]
    make: "Callable[[Results, Monitor], Product]"
    load: "Callable[[Results], Any] | None"
    result: str
    files: tuple[str, ...]
    section: str
    words: Callable[[Section], str]
    shown: tuple[tuple[str, str], ...]
    next_step: str
    sufficient: Callable[[Config], tuple[Config, ...]] = _itself
    in_summary: Callable[[Section | None], Section] = own_or_skipped
    quotes_upstream: bool = False
    withheld: "Callable[[Section], NoSolutionError | None]" = _nothing
    explain: "Callable[[Results, Monitor], Diagnosis] | None" = None
    report: "Callable[[Results, State], bytes] | None" = None
    beside: tuple[Stage, ...] = ()
    completes: tuple[Stage, ...] = ()

    @property
    def patterns(self) -> tuple[str, ...]:
        """All files of the stage, those of a failure included."""
        return (*self.files, *failure_files_of(self.stage))


Specs = tuple[StageSpec, ...]
_COMPARE = "gantry-tau compare {folder}, and figures with gantry-tau run {config}{out}"

SPECS: Specs = (
    StageSpec(
        stage=Stage.REGIONS,
        upstream=(),
        config_part=regions_part,
        make=Deferred("pipeline.run.makers.regions", "make_regions"),
        load=Deferred("pipeline.artifacts.results.regions", "load_regions"),
        result=REGIONS_NPZ,
        files=(REGIONS_NPZ,),
        section="regions",
        words=Deferred("pipeline.summary.regions", "regions_words"),
        shown=((REGIONS_NPZ, "the region table, one array per column"),),
        next_step="gantry-tau refine {config}{out}",
    ),
    StageSpec(
        stage=Stage.ROUTE,
        upstream=(Stage.REGIONS,),
        config_part=route_part,
        make=Deferred("pipeline.run.makers.route", "make_route"),
        load=Deferred("pipeline.artifacts.results.route", "load_route"),
        result=ROUTE_NPZ,
        files=(ROUTE_NPZ, ROUTE_CSV),
        section="route",
        words=Deferred("pipeline.summary.route", "route_words"),
        shown=((ROUTE_CSV, "the route, one row per step"),),
        next_step="gantry-tau refine {config}{out}",
        withheld=Deferred("pipeline.summary.route", "unproven_route"),
        explain=Deferred("pipeline.run.diagnosis", "diagnose"),
    ),
    StageSpec(
        stage=Stage.REFINE,
        upstream=(Stage.ROUTE,),
        config_part=refine_part,
        make=Deferred("pipeline.run.makers.path", "make_path"),
        load=Deferred("pipeline.artifacts.results.path", "load_refinement"),
        result=PATH_NPZ,
        files=(PATH_NPZ, PATH_CSV, CORRECTION_CSV),
        section="path",
        words=Deferred("pipeline.summary.path", "path_words"),
        shown=((PATH_NPZ, "the path as splines"), (PATH_CSV, "the path, densely sampled")),
        next_step=_COMPARE,
    ),
    StageSpec(
        stage=Stage.CERTIFY,
        upstream=(Stage.REFINE,),
        config_part=certify_part,
        make=Deferred("pipeline.run.makers.certificate", "make_certificate"),
        load=Deferred("pipeline.artifacts.results.certificate.stored", "load_certificate"),
        result=CERTIFICATE_JSON,
        files=(CERTIFICATE_JSON, CALIBRATION_JSON, FOLLOWING_CSV, POSE_ERROR_CSV, POSE_ERROR_NPZ),
        section="certificate",
        words=Deferred("pipeline.summary.certificate", "certificate_words"),
        shown=(
            (CERTIFICATE_JSON, "the proof that the path is free of singularities, and its bounds"),
            (FOLLOWING_CSV, "by how much drives may be off the path, over s"),
            (POSE_ERROR_CSV, "how far the tool may be off, over s"),
        ),
        next_step=_COMPARE,
        sufficient=with_sufficient_proofs,
        in_summary=Deferred("pipeline.summary.certificate", "certificate_in_summary"),
    ),
    StageSpec(
        stage=Stage.RETIME,
        upstream=(Stage.REFINE,),
        config_part=retime_part,
        make=Deferred("pipeline.run.makers.trajectory", "make_trajectory"),
        load=Deferred("pipeline.artifacts.results.trajectory", "load_trajectory"),
        result=TRAJECTORY_NPZ,
        files=(TRAJECTORY_NPZ, TRAJECTORY_CSV, TRAJECTORY_JSON, BACK_CSV, BACK_JSON),
        section="trajectory",
        words=Deferred("pipeline.summary.trajectory", "trajectory_words"),
        shown=(
            (TRAJECTORY_CSV, "for the controller: one row per period"),
            (BACK_CSV, "the same for the way back"),
        ),
        next_step=_COMPARE,
        completes=(Stage.CERTIFY,),
    ),
    StageSpec(
        stage=Stage.FIGURES,
        upstream=(Stage.REGIONS, Stage.ROUTE, Stage.REFINE, Stage.CERTIFY, Stage.RETIME),
        config_part=whole_config,
        make=Deferred("pipeline.run.makers.figures", "make_figures"),
        load=None,
        result="",
        files=(REPORT, *FIGURE_PATTERNS),
        section="figures",
        words=Deferred("pipeline.summary.figures", "figures_words"),
        shown=(
            (REPORT, "to open in a browser: the machine in motion, kappa around it, the proof, all key figures"),
            (FIGURES, "figures: the route, the machine, kappa, clearance, motion over time"),
        ),
        next_step="open {report} in a browser, then gantry-tau compare {folder}",
        quotes_upstream=True,
        report=Deferred("pipeline.run.makers.report_page", "report_page"),
        beside=STAGES,
    ),
)
"""The stages in the order in which they run."""


def spec_of(specs: Specs, stage: Stage) -> StageSpec:
    """Give the row of a stage."""
    return next(spec for spec in specs if spec.stage is stage)


def stages_up_to(specs: Specs, last: Stage) -> tuple[Stage, ...]:
    """Name the stages of a run that ends with one: it, and those that its result, or theirs, builds on or completes."""
    wanted = {last}
    for spec in reversed(specs):
        if spec.stage in wanted:
            wanted |= {*spec.upstream, *spec.completes}
    return tuple(spec.stage for spec in specs if spec.stage in wanted)


def report_of(specs: Specs) -> "Callable[[Results, State], bytes]":
    """Give the function that makes a report from the results so far."""
    return next(spec.report for spec in specs if spec.report is not None)


def code_roots(specs: Specs, stage: Stage) -> tuple[str, ...]:
    """Name the modules in which the code of a stage begins: all that it imports belongs to it."""
    spec = spec_of(specs, stage)
    upstream = [spec_of(specs, name) for name in spec.upstream]
    loaded = [*upstream, *(spec_of(specs, name) for name in spec.completes)]
    functions = [spec.make, spec.words, spec.in_summary, *(earlier.load for earlier in loaded)]
    if spec.quotes_upstream:
        functions += [earlier.words for earlier in upstream]
    return tuple(dict.fromkeys(_module(function) for function in functions if function is not None))


def _module(function: Callable[..., object]) -> str:
    return function.module if isinstance(function, Deferred) else function.__module__
