"""What solvers that must not share a process with HiGHS need: OR-Tools brings its own, and the two collide."""

from pathlib import Path

import numpy as np
import numpy.typing as npt

REGIONS, PROGRAM = "regions.npz", "compact.mps"


def read_sequence(
    folder: Path, values: npt.NDArray[np.float64]
) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.float64]]:
    """Read the region and the x of every step from a solution of the compact program."""
    with np.load(folder / REGIONS) as arrays:
        table = values.reshape(int(arrays["step_budget"]), -1)
    return np.argmax(table[:, 1:], axis=1), table[:, 0]
