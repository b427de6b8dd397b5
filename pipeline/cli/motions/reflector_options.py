"""Options for up to three reflectors on the platform."""

from typing import TYPE_CHECKING, Annotated

import typer

from pipeline.errors import UsageError

if TYPE_CHECKING:
    from pipeline.arrays import FloatArray

Point = tuple[float, float, float]
FirstReflector = Annotated[
    Point | None,
    typer.Option("--reflector-1", metavar="X Y Z", help="First reflector on the platform, in metres."),
]
SecondReflector = Annotated[
    Point | None, typer.Option("--reflector-2", metavar="X Y Z", help="Second reflector, if there is one.")
]
ThirdReflector = Annotated[Point | None, typer.Option("--reflector-3", metavar="X Y Z", help="Third reflector.")]


def reflector_places(first: Point | None, second: Point | None, third: Point | None) -> "FloatArray":
    """Put the reflectors that are given into rows (n, 3).

    Raises
    ------
    UsageError
        When the first is not given, the third without the second, or one is not in metres.
    """
    import numpy as np

    from pipeline.measured.reflectors import require_places

    if first is None:
        raise UsageError("--reflector-1 X Y Z is missing: where the reflector is on the platform, in metres")
    if second is None and third is not None:
        raise UsageError("--reflector-3 is given, but not --reflector-2")
    return require_places(np.array([point for point in (first, second, third) if point is not None]))
