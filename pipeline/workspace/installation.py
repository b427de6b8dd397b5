"""How much of the space that a machine takes up it can use: the measure by which designs are compared.

The *frame* is the least rectangle of the YZ plane around the three rails, the *installation space* the box of the frame
along the travel of the carts, the *footprint* its floor. Links and platform reach beyond: in a mode where all arms are
on one side, most of what the machine uses is beside its frame, and ratios above one are possible. Workspaces are those
of all working modes together, without tilt, as of `usable_workspace`.

Tyapin and Hovland (2009) optimise a workspace/footprint ratio of the 3-DOF Gantry-Tau, over the lengths of its support
frame among others.
"""

from dataclasses import dataclass

import numpy as np

from pipeline.machine.geometry import Machine
from pipeline.machine.rails import with_parallel_rails
from pipeline.workspace.usable import WorkspaceSetting, step_for, usable_workspace

STEP_M = 0.02
"""Grid step at which volumes of machines of some metres are known to a few per mille, in a fifth of a second."""
_MOST_CELLS = 20_000


@dataclass(frozen=True)
class Installation:
    """The box around the rails, as far as the carts travel: its lengths along X, Y and Z."""

    x_m: float
    y_m: float
    z_m: float

    @property
    def frame_m2(self) -> float:
        """Area of the frame, across the rails."""
        return self.y_m * self.z_m

    @property
    def footprint_m2(self) -> float:
        """Area of the floor."""
        return self.x_m * self.y_m

    @property
    def volume_m3(self) -> float:
        """Volume of the installation space."""
        return self.x_m * self.y_m * self.z_m


@dataclass(frozen=True)
class SpaceUse:
    """A workspace against the installation space of its machine.

    Attributes
    ----------
    setting : WorkspaceSetting
        What counts as usable.
    installation : Installation
        The space that the machine takes up.
    volume_m3, area_m2 : float
        What at least one working mode can use, and the part of the YZ plane that it can use at some x.
    """

    setting: WorkspaceSetting
    installation: Installation
    volume_m3: float
    area_m2: float

    @property
    def volume_ratio(self) -> float | None:
        """Usable volume per volume of the installation space; None where the rails lie in a plane."""
        return _ratio(self.volume_m3, self.installation.volume_m3)

    @property
    def area_ratio(self) -> float | None:
        """Usable area across the rails per area of the frame; None where the rails lie in a plane."""
        return _ratio(self.area_m2, self.installation.frame_m2)

    @property
    def volume_per_footprint_m(self) -> float | None:
        """Usable volume per area of the floor, in metres; None where all rails are one above the other."""
        return _ratio(self.volume_m3, self.installation.footprint_m2)


def installation_of(machine: Machine) -> Installation:
    """Measure the box around the rails of a machine, as parallel as its workspace takes them to be."""
    machine = with_parallel_rails(machine)
    y, z = np.ptp(machine.rails_m, axis=0).tolist()
    return Installation(float(machine.travel_m.max() - machine.travel_m.min()), y, z)


def measure_space(machine: Machine, setting: WorkspaceSetting | None = None) -> SpaceUse:
    """Measure a machine's workspace against its installation space; by default at a step that takes little time.

    Raises
    ------
    UsageError
        When the step makes too many cells.
    """
    setting = WorkspaceSetting(step_m=step_for(machine, STEP_M, _MOST_CELLS)) if setting is None else setting
    workspace = usable_workspace(machine, setting)
    return SpaceUse(setting, installation_of(machine), workspace.union_m3, workspace.union_area_m2)


def _ratio(value: float, of: float) -> float | None:
    return value / of if of > 0.0 else None
