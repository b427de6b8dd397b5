"""The file of a study: what is varied and how, how far each run goes, and which figures are kept."""

import difflib
from enum import StrEnum
from pathlib import Path
from typing import Any, Self

from pydantic import BaseModel, Field, ValidationError, model_validator
from pydantic_core import ErrorDetails, PydanticCustomError

from pipeline.config.file import read_yaml
from pipeline.config.messages import key_path
from pipeline.config.section import MOST_NAME, NAME_PATTERN, Section
from pipeline.errors import ConfigError, ConfigIssue
from pipeline.stage import Stage

MOST_RUNS = 10_000_000
"""Runs of the largest study."""
_MOST_VALUES = 1_000_000


class Last(StrEnum):
    """How far a run goes: up to a stage, or to the simulated twin after `retime`."""

    REGIONS = Stage.REGIONS.value
    ROUTE = Stage.ROUTE.value
    REFINE = Stage.REFINE.value
    CERTIFY = Stage.CERTIFY.value
    RETIME = Stage.RETIME.value
    FIGURES = Stage.FIGURES.value
    SIMULATE = "simulate"


class Kind(StrEnum):
    """How the parameters of a study are combined."""

    GRID = "grid"
    ZIPPED = "zipped"
    LIST = "list"
    RANDOM = "random"
    SOBOL = "sobol"
    OPTIMISE = "optimise"


class Sampler(StrEnum):
    """What chooses the points of an optimisation."""

    TPE = "tpe"
    NSGA2 = "nsga2"


class Keep(StrEnum):
    """Which run folders are kept when their rows are."""

    ALL = "all"
    FAILED = "failed"
    NONE = "none"


SAMPLED = (Kind.RANDOM, Kind.SOBOL, Kind.OPTIMISE)
"""Designs that draw points, and need to know how many."""
_MOST_TRIALS = 10_000
"""Runs of the largest optimisation: a sampler takes the longer for a point the more it knows."""


class ParameterConfig(BaseModel):
    """One key of the configuration that varies, or several that vary together: listed values, or a range."""

    model_config = Section.model_config

    key: str | None = Field(None, max_length=200, description="the key's path, such as task.tilt_max_deg")
    keys: tuple[str, ...] = Field((), max_length=50, description="several keys that vary together")
    values: tuple[Any, ...] = Field(
        (), max_length=_MOST_VALUES, description="the values; with keys, each is a list with one value per key"
    )
    min: float | None = Field(None, description="least value of a range")
    max: float | None = Field(None, description="largest value of a range")
    count: int | None = Field(
        None, ge=1, le=_MOST_VALUES, description="how many values of the range, ends included: for grid and zipped"
    )
    log: bool = Field(False, description="the range is divided, or drawn from, on a logarithmic scale")

    @property
    def paths(self) -> tuple[str, ...]:
        """The paths of all keys that vary."""
        return self.keys if self.key is None else (self.key,)

    @model_validator(mode="after")
    def _whole(self) -> Self:
        if (self.key is None) == (not self.keys):
            raise _rule("needs exactly one of key and keys")
        ends = (self.min is not None, self.max is not None)
        if bool(self.values) == any(ends) or any(ends) != all(ends):
            raise _rule("needs either values, or min and max")
        if self.keys and not self.values:
            raise _rule("has several keys, which need values: a list of lists, with one value per key")
        for index, value in enumerate(self.values if self.keys else ()):
            if not isinstance(value, list) or len(value) != len(self.keys):
                raise _rule(f"has in values[{index}] other than a list of {len(self.keys)}, one per key")
        if self.min is not None and self.max is not None:
            if self.min >= self.max:
                raise _rule(f"has min {self.min:g}, which is not below max ({self.max:g})")
            if self.log and self.min <= 0.0:
                raise _rule(f"has min {self.min:g}; with log: on it has to be above 0")
        return self


class DesignConfig(Section):
    """How the parameters are combined, and how many points are drawn."""

    kind: Kind = Field(
        Kind.GRID,
        description="grid: every combination, the last parameter varies fastest; zipped: the first values together, "
        "then the second, ...; list: the points given; random, sobol: points drawn from ranges and values; "
        "optimise: points chosen by the results so far, for the figures of pareto",
    )
    samples: int | None = Field(None, ge=1, le=MOST_RUNS, description="points drawn: for random, sobol and optimise")
    seed: int = Field(0, ge=0, le=2**32 - 1, description="of the points drawn")
    sampler: Sampler = Field(
        Sampler.TPE,
        description="of optimise: tpe models which values are good, and is best for up to some hundred points; nsga2 "
        "breeds generations",
    )
    initial: int = Field(
        16, ge=2, le=_MOST_TRIALS, description="of optimise: points drawn at random first; with nsga2 a generation"
    )
    parallel: int = Field(
        4,
        ge=1,
        le=_MOST_TRIALS,
        description="of optimise: runs at a time; each point is chosen by the results of all runs but the last so many "
        "before it, however many workers there are",
    )

    @model_validator(mode="after")
    def _of_optimise(self) -> Self:
        if self.kind is Kind.OPTIMISE:
            if (self.samples or 0) > _MOST_TRIALS:
                raise _rule(f"has samples {self.samples:,}; kind optimise allows {_MOST_TRIALS:,}")
        elif given := self.model_fields_set & {"sampler", "initial", "parallel"}:
            raise _rule(f"has {min(given)}, which only kind optimise uses")
        return self


class ConstraintConfig(BaseModel):
    """A figure that has to keep within bounds for a run to count."""

    model_config = Section.model_config

    figure: str = Field(min_length=1, max_length=200, description="a figure of summary.json, by path")
    min: float | None = Field(None, description="least value")
    max: float | None = Field(None, description="largest value")

    @model_validator(mode="after")
    def _bounded(self) -> Self:
        if self.min is None and self.max is None:
            raise _rule("needs min, max or both")
        if self.min is not None and self.max is not None and self.min > self.max:
            raise _rule(f"has min {self.min:g}, which is above max ({self.max:g})")
        return self


class PerturbConfig(Section):
    """A machine whose geometry is a little off: normal deviations of joints, rails and lengths, the same per seed."""

    geometry_m: float = Field(0.0, ge=0.0, le=0.05, description="standard deviation of every coordinate and length")
    seed: int = Field(0, ge=0, le=2**32 - 1, description="of the deviations")


class TwinConfig(Section):
    """What the twin deviates from the model by, for `to: simulate`."""

    geometry_m: float = Field(0.0, ge=0.0, le=0.01, description="standard deviation of joints, rails, lengths")
    seed: int = Field(0, ge=0, le=2**32 - 1, description="of the deviations of the geometry")
    mass_error_percent: float = Field(0.0, ge=-90.0, le=900.0, description="by how much all masses are larger")
    load_kg: float = Field(0.0, ge=0.0, le=10_000.0, description="a load at the TCP beside the plan's")


class RunConfig(Section):
    """What every run of a study may take."""

    time_limit_s: float = Field(3600.0, gt=0.0, le=1e7, description="after it a run is stopped, and marked")
    threads: int = Field(1, ge=1, le=256, description="processors that a run may use")
    keep: Keep = Field(
        Keep.ALL, description="run folders that are kept with all their files; of the others only the row is"
    )
    why_not: bool = Field(False, description="where no route exists, find out what prevents it: minutes per run")


class StudyConfig(Section):
    """A study: a configuration, what varies in it, and what is kept of every run."""

    name: str = Field("", pattern=NAME_PATTERN, max_length=MOST_NAME, description="of the study; default: the file's")
    base: str = Field(min_length=1, description="the configuration that varies, from the study's folder")
    to: Last = Field(Last.RETIME, description="the stage after which every run ends")
    design: DesignConfig = Field(default_factory=lambda: DesignConfig())
    parameters: tuple[ParameterConfig, ...] = Field((), max_length=100, description="what varies")
    points: tuple[dict[str, Any], ...] = Field(
        (), max_length=_MOST_VALUES, description="for design.kind list: every point, as key paths with their values"
    )
    perturb: PerturbConfig = Field(default_factory=lambda: PerturbConfig())
    twin: TwinConfig = Field(default_factory=lambda: TwinConfig())
    figures: tuple[str, ...] = Field(
        (), max_length=200, description="figures of summary.json for the table, by path; none: all that are numbers"
    )
    pareto: tuple[str, ...] = Field(
        (), max_length=4, description="figures of which less is better, for the Pareto front; -name: more is better"
    )
    constraints: tuple[ConstraintConfig, ...] = Field(
        (), max_length=20, description="bounds of figures; a run beyond them is not on the Pareto front"
    )
    run: RunConfig = Field(default_factory=lambda: RunConfig())

    @property
    def kept_figures(self) -> tuple[str, ...]:
        """The figures of the table: those asked for, and those that are weighed; none: all that are numbers."""
        weighed = (*(name.removeprefix("-") for name in self.pareto), *(one.figure for one in self.constraints))
        return tuple(dict.fromkeys((*self.figures, *weighed))) if self.figures else ()

    @model_validator(mode="after")
    def _design_fits(self) -> Self:
        kind = self.design.kind
        if kind is Kind.LIST and (not self.points or self.parameters):
            raise _rule("has design.kind list, which needs points, and no parameters")
        if kind is not Kind.LIST and (self.points or not self.parameters):
            raise _rule(f"has design.kind {kind}, which needs parameters, and no points: it is empty otherwise")
        if (kind in SAMPLED) != (self.design.samples is not None):
            raise _rule("needs design.samples for design.kind random, sobol and optimise, and for no other")
        if kind is Kind.OPTIMISE and not self.pareto:
            raise _rule("has design.kind optimise, which needs in pareto the figures that are optimised")
        for index, one in enumerate(self.parameters):
            if one.values == () and (kind in SAMPLED) == (one.count is not None):
                raise _rule(f"needs parameters[{index}].count with a range of a grid or zipped design, and only there")
        paths = [path for one in self.parameters for path in one.paths]
        if twice := sorted({path for path in paths if paths.count(path) > 1}):
            raise _rule(f"varies {twice[0]} twice")
        return self


def load_study(path: Path | str) -> StudyConfig:
    """Read and validate the file of a study; the name defaults to the file's.

    Raises
    ------
    ConfigError
        When it cannot be read or is not valid; names every offending key.
    """
    path = Path(path)
    return parse_study(read_yaml(path), str(path), path.stem)


def parse_study(data: object, source: str = "study", default_name: str = "study") -> StudyConfig:
    """Validate a nested dictionary as `load_study` does a file.

    Raises
    ------
    ConfigError
        When it is not valid; names every offending key.
    """
    if not isinstance(data, dict):
        raise ConfigError([ConfigIssue("(top level)", "must be a section with the keys base and parameters")], source)
    try:
        study = StudyConfig.model_validate(data)
    except ValidationError as error:
        raise ConfigError([_explain(one) for one in error.errors(include_url=False)], source) from None
    return study if study.name else study.model_copy(update={"name": default_name})


def _rule(message: str) -> PydanticCustomError:
    return PydanticCustomError("rule", "{message}", {"message": message})


def _explain(error: ErrorDetails) -> ConfigIssue:
    """Turn one error of pydantic's into a key's path and what is wrong there, with the keys known beside it."""
    location = error["loc"]
    path = key_path(location)
    if error["type"] != "extra_forbidden":
        shown = "" if error["type"] in ("rule", "missing") else f" (it is {error['input']!r})"
        return ConfigIssue(path, f"{error['msg'][:1].lower()}{error['msg'][1:]}{shown}", error["input"])
    keys = list(_section_at(location[:-1]).model_fields)
    close = difflib.get_close_matches(str(location[-1]), keys, n=1)
    meant = f" (did you mean {close[0]}?)" if close else ""
    return ConfigIssue(path, f"is not a known key{meant}; allowed here are {', '.join(keys)}", error["input"])


_SECTIONS: dict[str, type[BaseModel]] = {
    "design": DesignConfig,
    "parameters": ParameterConfig,
    "constraints": ConstraintConfig,
    "perturb": PerturbConfig,
    "twin": TwinConfig,
    "run": RunConfig,
}


def _section_at(location: tuple[int | str, ...]) -> type[BaseModel]:
    return _SECTIONS[str(location[0])] if location else StudyConfig
