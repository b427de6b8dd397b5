"""The points of a study: values by key path, in an order that depends on nothing but the study's file."""

import itertools
import math
from collections.abc import Callable, Iterator, Sequence

import numpy as np
from scipy.stats import qmc

from pipeline.arrays import FloatArray
from pipeline.errors import ConfigError, ConfigIssue
from pipeline.study.config import MOST_RUNS, DesignConfig, Kind, ParameterConfig, StudyConfig

Point = dict[str, object]
"""The values of one run by key path."""


def count_points(study: StudyConfig) -> int:
    """Count the points of a study.

    Raises
    ------
    ConfigError
        When parameters that go together differ in length, or there are too many points.
    """
    counts = [_count(one) for one in study.parameters]
    if study.design.kind is Kind.LIST:
        return len(study.points)
    if study.design.samples is not None:
        return study.design.samples
    if study.design.kind is Kind.ZIPPED and len(set(counts)) > 1:
        named = ", ".join(f"{one.paths[0]} has {n}" for one, n in zip(study.parameters, counts, strict=True))
        raise ConfigError([ConfigIssue("parameters", f"zipped need equally many values: {named}")], study.name)
    count = counts[0] if study.design.kind is Kind.ZIPPED else math.prod(counts)
    if count > MOST_RUNS:
        raise ConfigError([ConfigIssue("parameters", f"make {count:,} runs; allowed are {MOST_RUNS:,}")], study.name)
    return count


def varied_paths(study: StudyConfig) -> tuple[str, ...]:
    """Name the keys that vary, in the order of the study's file."""
    given = study.points or [one.paths for one in study.parameters]
    return tuple(dict.fromkeys(path for paths in given for path in paths))


def points(study: StudyConfig) -> Iterator[Point]:
    """Give the points in their order; those drawn are the same for the same seed.

    Raises
    ------
    ValueError
        For an optimisation: its points follow from its results.
    """
    kind = study.design.kind
    if kind is Kind.OPTIMISE:
        raise ValueError("the points of an optimisation follow from its results")
    if kind is Kind.LIST:
        yield from (dict(point) for point in study.points)
        return
    if study.design.samples is not None:
        yield from _drawn(study.design, study.design.samples, study.parameters)
        return
    axes = [listed(one) for one in study.parameters]
    for chosen in zip(*axes, strict=True) if kind is Kind.ZIPPED else itertools.product(*axes):
        yield {key: value for point in chosen for key, value in point.items()}


def _count(parameter: ParameterConfig) -> int:
    return len(parameter.values) or parameter.count or 0


def listed(parameter: ParameterConfig) -> list[Point]:
    """List the values of a parameter, each as a point of its own."""
    if parameter.keys:
        return [dict(zip(parameter.keys, value, strict=True)) for value in parameter.values]
    (key,) = parameter.paths
    if parameter.values:
        return [{key: value} for value in parameter.values]
    parts = np.linspace(0.0, 1.0, parameter.count or 1)
    return [{key: value} for value in _in_range(parameter)(parts).tolist()]


def _in_range(parameter: ParameterConfig) -> Callable[[FloatArray], FloatArray]:
    """Give the function from parts of a range, 0 to 1, to its values, rounded to 12 digits: 0.1, not 0.1000...01."""
    low, high = parameter.min or 0.0, parameter.max or 0.0

    def values(parts: FloatArray) -> FloatArray:
        exact = low * (high / low) ** parts if parameter.log else low + (high - low) * parts
        return np.clip([float(f"{value:.12g}") for value in exact], low, high)

    return values


def _drawn(design: DesignConfig, samples: int, parameters: Sequence[ParameterConfig]) -> Iterator[Point]:
    """Draw points of the unit cube, and look up what they stand for: of a list the value, of a range the number."""
    if design.kind is Kind.SOBOL:
        sampler = qmc.Sobol(len(parameters), scramble=True, rng=design.seed)
        unit = sampler.random_base2(math.ceil(math.log2(samples)))[:samples]
    else:
        unit = np.random.default_rng(design.seed).random((samples, len(parameters)))
    columns = [_looked_up(one, unit[:, k]) for k, one in enumerate(parameters)]
    for chosen in zip(*columns, strict=True):
        yield {key: value for point in chosen for key, value in point.items()}


def _looked_up(parameter: ParameterConfig, parts: FloatArray) -> list[Point]:
    if not parameter.values:
        return [{parameter.paths[0]: value} for value in _in_range(parameter)(parts).tolist()]
    points = listed(parameter)
    return [points[min(int(part * len(points)), len(points) - 1)] for part in parts]
