"""From points to cases: the configuration of every run, its folder, and the key by which its result is known."""

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import ValidationError

from pipeline.config import Config
from pipeline.config.file import config_sha256, load_config, parse_config
from pipeline.config.stages.route import RouteConfig
from pipeline.errors import ConfigError, ConfigIssue
from pipeline.machine.geometry import LINKS, build_machine
from pipeline.study.config import Last, PerturbConfig, StudyConfig, TwinConfig
from pipeline.study.design import Point, count_points, points, varied_paths
from pipeline.study.keys import UnknownKeyError, nested_paths, parts_of, replaced, value_at

_NOT_OF_THE_FOLDER = ("name", "twin")
_FOLDER_DIGITS = 16
_MEMORY_GB = RouteConfig.model_fields["memory_gb"].default
"""Of runs whose whole section `route` varies, and does not say."""
SECTIONS = ("perturb", "twin")
"""Sections of a study whose keys vary, too, beside those of the configuration."""


@dataclass(frozen=True)
class Case:
    """One run of a study.

    Attributes
    ----------
    number : int
        Its place in the design, from 1.
    point : dict
        The values that vary, by key path.
    data : dict
        The whole configuration, with sections `perturb` and `twin`.
    key : str
        Hash of configuration, last stage and program: results with the same key are the same.
    folder : str
        Name of its run folder: a hash of the configuration alone, so that a run can be taken further, and that the
        same motion is planned once for all deviations of the twin.
    """

    number: int
    point: Point
    data: dict[str, Any]
    key: str
    folder: str

    @property
    def memory_gb(self) -> float:
        """Memory that the run may take up."""
        return float(self.data["route"].get("memory_gb", _MEMORY_GB)) + 0.2


@dataclass(frozen=True)
class Cases:
    """All runs of a study, made when they are asked for.

    Attributes
    ----------
    study : StudyConfig
        The study.
    base : dict
        The configuration that varies, resolved, with sections `perturb` and `twin`.
    program : str
        Version of the program, with a hash of its code.
    """

    study: StudyConfig
    base: Mapping[str, Any]
    program: str

    def __len__(self) -> int:
        return count_points(self.study)

    def __iter__(self) -> Iterator[Case]:
        for number, point in enumerate(points(self.study), 1):
            yield self.case(number, point)

    def case(self, number: int, point: Point) -> Case:
        """Make the case of a point whose keys exist."""
        whole = _written(self.base, self.study, point)
        data = replaced(self.base, whole)
        folder = config_sha256({key: value for key, value in data.items() if key not in _NOT_OF_THE_FOLDER})
        name = f"{self.study.name[:40]}-{folder[:8]}"
        content = {"config": folder, "to": self.study.to, "program": self.program}
        if self.study.to is Last.SIMULATE:
            content["twin"] = data["twin"]
        return Case(number, whole, {**data, "name": name}, config_sha256(content), folder[:_FOLDER_DIGITS])


def build_cases(study: StudyConfig, file: Path, program: str) -> Cases:
    """Read the configuration of a study, and require that every value that varies is allowed, taken by itself.

    What is wrong with several of them together is found by the run.

    Raises
    ------
    ConfigError
        When the configuration is not valid, a path leads nowhere, a value is not allowed, or there are no points.
    """
    config = load_config(file.parent / study.base)
    base = config.model_dump(mode="json")
    base |= {name: getattr(study, name).model_dump(mode="json") for name in SECTIONS}
    if count_points(study) == 0:
        raise ConfigError([ConfigIssue("parameters", "make no run: the design is empty")], str(file))
    issues = [issue for place, point in _tried(study) if (issue := _issue(base, study, place, point))]
    if not issues and not study.points and (said := _overlap(varied_paths(study))):
        issues = [ConfigIssue("parameters", said)]
    if issues:
        raise ConfigError(issues, str(file))
    return Cases(study, base, program)


def parse_case(data: Mapping[str, Any]) -> tuple[Config, PerturbConfig, TwinConfig]:
    """Validate the data of a case.

    Raises
    ------
    ConfigError
        When it is not a valid configuration; names every offending key.
    """
    perturb, twin = PerturbConfig.model_validate(data["perturb"]), TwinConfig.model_validate(data["twin"])
    config = {key: value for key, value in data.items() if key not in SECTIONS}
    exact = parse_config(config)
    return parse_config(_perturbed(config, exact, perturb)) if perturb.geometry_m else exact, perturb, twin


def _tried(study: StudyConfig) -> Iterator[tuple[str, Point]]:
    """Give every value that varies with its place in the file: of a range the ends, of what varies together all."""
    for index, point in enumerate(study.points):
        yield f"points[{index}]", point
    for index, one in enumerate(study.parameters):
        place = f"parameters[{index}]"
        for k, value in enumerate(one.values):
            given = value if one.keys else [value]
            yield f"{place}.values[{k}]", dict(zip(one.paths, given, strict=True))
        if not one.values:
            yield f"{place}.min", {one.paths[0]: one.min}
            yield f"{place}.max", {one.paths[0]: one.max}


def _issue(base: Mapping[str, Any], study: StudyConfig, place: str, point: Point) -> ConfigIssue | None:
    """Say what is wrong with a point, if anything is: with its paths, or its values."""
    try:
        if unfit := next((path for path in point if parts_of(path)[0] == "name"), None):
            return ConfigIssue(place, f"{unfit} cannot vary: runs are named by the study")
        whole = _written(base, study, point)
        if said := _overlap(point):
            return ConfigIssue(place, said)
    except UnknownKeyError as error:
        return ConfigIssue(place, str(error))
    try:
        parse_case(replaced(base, whole))
    except ConfigError as error:
        return None if _together(error, whole) else ConfigIssue(place, "; ".join(map(str, error.issues)))
    except ValidationError as error:
        return ConfigIssue(place, f"{', '.join(whole)}: {error.errors()[0]['msg']}")
    return None


def _overlap(paths: Iterable[str]) -> str:
    """Say which of the paths contains another, or leads to the same value; empty if none does."""
    found = nested_paths(paths)
    return "" if found is None else f"varies both {found[0]} and {found[1]}: give one of them, with all that varies"


def _together(error: ConfigError, point: Point) -> bool:
    """Check whether a refusal is about other keys than those that vary: others that vary may make up for it."""
    return not any(
        issue.path.startswith(path) or path.startswith(issue.path) for issue in error.issues for path in point
    )


def _written(base: Mapping[str, Any], study: StudyConfig, point: Point) -> Point:
    """Write the values of a point as the configuration writes them.

    Raises
    ------
    UnknownKeyError
        When a path leads nowhere.
    """
    ranges = {path for one in study.parameters if not one.values for path in one.paths}
    return {path: _like(value_at(base, path), value, path in ranges) for path, value in point.items()}


def _like(known: object, value: object, of_range: bool) -> object:
    """Write a value as one is written: 5 for a length is 5.0, 5.0 for a count is 5, and so is 5.3 of a range."""
    if isinstance(known, bool) or isinstance(value, bool) or not isinstance(value, int | float):
        return value
    if isinstance(known, float):
        return float(value)
    if isinstance(known, int) and math.isfinite(value) and (of_range or value == round(value)):
        return round(value)
    return value


def _perturbed(config: Mapping[str, Any], exact: Config, perturb: PerturbConfig) -> dict[str, Any]:
    """Move joints and rails, and change lengths, by normal deviations that depend on the seed alone.

    Link 3c has the length then that it has in the exact machine, also where that follows from a right angle.
    """
    random = np.random.default_rng(perturb.seed)

    def off(value: Any) -> Any:
        if isinstance(value, list):
            return [off(item) for item in value]
        return value if value is None else value + random.normal(0.0, perturb.geometry_m)

    moved = {"y_m", "z_m", "platform_point_m", "cart_offset_m", "length_m"}
    machine = config["machine"]
    rails = [{key: off(value) if key in moved else value for key, value in rail.items()} for rail in machine["rails"]]
    lengths_m = dict(zip(LINKS, build_machine(exact.machine).lengths_m.tolist(), strict=True))
    given = {**machine["links"], "l3c": {**machine["links"]["l3c"], "length_m": lengths_m["3c"]}}
    links = {
        name: {key: off(value) if key in moved else value for key, value in link.items()}
        for name, link in given.items()
    }
    return {**config, "machine": {**machine, "rails": rails, "links": links}}
