"""Trajectories in any of the formats, by its name: written, and read back."""

from collections.abc import Callable, Sequence
from importlib import import_module
from typing import Any

from pipeline.arrays import FloatArray
from pipeline.errors import UsageError
from pipeline.export.formats import Format
from pipeline.export.motion import Motion
from pipeline.export.request import CsvOptions, ExportRequest
from pipeline.retime.result import TrajectorySamples


def format_samples(
    kind: Format,
    samples: TrajectorySamples,
    acceleration_mps2: FloatArray,
    joint_names: Sequence[str],
    options: CsvOptions | None = None,
) -> str:
    """Write samples in a format, with as many decimals as the period and the limits (5,) need, or all digits.

    Raises
    ------
    UsageError
        When the options cannot be met, or are given for another format than CSV.
    """
    options = options or CsvOptions()
    if kind is not Format.CSV and options != CsvOptions():
        raise UsageError("--separator, --decimals, --columns, --length and --angle go with --format csv only")
    text: str = _function(kind.writer)(ExportRequest(samples, acceleration_mps2, joint_names, options))
    return text


def read_motion(kind: Format, text: str) -> Motion:
    """Read the motion of the actuators back from a text in a format.

    Raises
    ------
    ValueError
        When the text is not in that format.
    """
    motion: Motion = _function(kind.reader)(text)
    return motion


def _function(reference: str) -> Callable[..., Any]:
    module, name = reference.split(".")
    function: Callable[..., Any] = getattr(import_module(f"pipeline.export.{module}"), name)
    return function
