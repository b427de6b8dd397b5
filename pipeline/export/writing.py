"""Trajectories in any of the formats, by its name: written, and read back."""

from collections.abc import Callable, Sequence
from importlib import import_module
from typing import Any

from pipeline.arrays import FloatArray
from pipeline.errors import UsageError
from pipeline.export.formats import Format
from pipeline.export.motion import Motion
from pipeline.export.request import ExportOptions, ExportRequest
from pipeline.machine.geometry import Machine
from pipeline.retime.result import TrajectorySamples


def export_files(kind: Format, request: ExportRequest) -> dict[str, bytes]:
    """Write a trajectory in a format: the content of its files by suffix, "" for the file itself.

    Files that belong beside it are left out where there is nothing to say in them. Positions are the controller's, but
    for formats that show the machine itself.

    Raises
    ------
    UsageError
        When the options cannot be met or are another format's, or the format cannot hold the motion or the machine.
    """
    request.options.require_for(kind)
    if not kind.shows_the_machine:
        request = request.for_controller()
    contents = {suffix: _function(writer)(request) for suffix, writer in {"": kind.writer, **kind.beside}.items()}
    return {
        suffix: one.encode() if isinstance(one, str) else bytes(one)
        for suffix, one in contents.items()
        if one is not None
    }


def format_samples(
    kind: Format,
    samples: TrajectorySamples,
    acceleration_mps2: FloatArray,
    joint_names: Sequence[str],
    options: ExportOptions | None = None,
    machine: Machine | None = None,
) -> str:
    """Write samples in a format of text, with as many decimals as the period and the limits (5,) need, or all digits.

    Files that belong beside it are left out: `export_files` has them.

    Raises
    ------
    UsageError
        When the options cannot be met, or are given for another format; when the format is not text.
    """
    request = ExportRequest(samples, acceleration_mps2, joint_names, options or ExportOptions(), machine)
    request.options.require_for(kind)
    content = _function(kind.writer)(request)
    if not isinstance(content, str):
        raise UsageError(f"{kind} is not text: use export_files")
    return content


def read_motion(kind: Format, content: str | bytes) -> Motion:
    """Read the motion of the actuators back from the content of a file in a format.

    Raises
    ------
    ValueError
        When the content is not in that format.
    UsageError
        When the format holds no motion.
    """
    if not kind.reader:
        raise UsageError(f"{kind} describes the machine and holds no motion")
    motion: Motion = _function(kind.reader)(content)
    return motion


def _function(reference: str) -> Callable[..., Any]:
    module, name = reference.rsplit(".", 1)
    function: Callable[..., Any] = getattr(import_module(f"pipeline.export.{module}"), name)
    return function
