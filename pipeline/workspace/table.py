"""The usable workspace in numbers: a row per working mode and one for all of them, at two grid steps."""

from dataclasses import dataclass, replace

import numpy as np

from pipeline.limits import pose_limits
from pipeline.limits.actuators import cart_travel
from pipeline.machine.geometry import MODES, Machine
from pipeline.summary.workspace import space_figures
from pipeline.workspace.installation import SpaceUse, installation_of
from pipeline.workspace.usable import Workspace, WorkspaceSetting, usable_workspace

UNION = "union"
"""Name of the row that takes all working modes together."""
TABLE_HEADER = ("working mode", "volume m^3", "area m^2", "union / mode", "volume at twice the step m^3", "change %")
"""Headings of `table_cells`."""


@dataclass(frozen=True)
class WorkspaceRow:
    """What one working mode, or the union of all, can use.

    Attributes
    ----------
    mode : str
        LLL to RRR, or union.
    volume_m3, area_m2 : float
        Usable volume, and the part of the YZ plane below it.
    union_ratio : float or None
        Volume of the union over this one; None where this one is empty.
    coarse_volume_m3 : float
        The volume at twice the grid step.
    change_per_cent : float or None
        The volume against the one at twice the step, in per cent of the latter; None where that is zero.
    """

    mode: str
    volume_m3: float
    area_m2: float
    union_ratio: float | None
    coarse_volume_m3: float
    change_per_cent: float | None


def at_two_steps(machine: Machine, setting: WorkspaceSetting) -> tuple[Workspace, Workspace]:
    """Compute the workspace at the setting's grid step and at twice that, so that convergence is seen."""
    coarse = replace(setting, step_m=2.0 * setting.step_m)
    return usable_workspace(machine, setting), usable_workspace(machine, coarse)


def workspace_rows(fine: Workspace, coarse: Workspace) -> list[WorkspaceRow]:
    """Put volumes, areas and ratios of the eight working modes and their union into rows, the union last."""
    names = [*MODES, UNION]
    volumes = [*fine.volumes_m3.tolist(), fine.union_m3]
    areas = [*fine.areas_m2.tolist(), fine.union_area_m2]
    coarse_volumes = [*coarse.volumes_m3.tolist(), coarse.union_m3]
    return [
        WorkspaceRow(
            mode=name,
            volume_m3=volume,
            area_m2=area,
            union_ratio=fine.union_m3 / volume if volume > 0.0 else None,
            coarse_volume_m3=before,
            change_per_cent=100.0 * (volume - before) / before if before > 0.0 else None,
        )
        for name, volume, area, before in zip(names, volumes, areas, coarse_volumes, strict=True)
    ]


def table_cells(rows: list[WorkspaceRow]) -> list[tuple[str, ...]]:
    """Format rows as text under `TABLE_HEADER`; what does not exist is a dash."""
    return [
        (
            row.mode,
            f"{row.volume_m3:.4f}",
            f"{row.area_m2:.4f}",
            "-" if row.union_ratio is None else f"{row.union_ratio:.3f}",
            f"{row.coarse_volume_m3:.4f}",
            "-" if row.change_per_cent is None else f"{row.change_per_cent:+.2f}",
        )
        for row in rows
    ]


def setting_text(machine: Machine, setting: WorkspaceSetting) -> str:
    """Say in one line what counts as usable."""
    limits = ", ".join(limit.requirement for limit in (*pose_limits(machine, setting.kappa_max), cart_travel(machine)))
    tilt = f"rx {np.rad2deg(setting.rx_rad):g} deg, rz {np.rad2deg(setting.rz_rad):g} deg"
    return f"{tilt}, {limits}, grid step {setting.step_m:g} m"


def space_text(machine: Machine, setting: WorkspaceSetting, union: WorkspaceRow) -> str:
    """Say in one line how the workspace of all modes compares with the space that the machine takes up."""
    use = SpaceUse(setting, installation_of(machine), union.volume_m3, union.area_m2)
    box = use.installation
    if use.volume_ratio is None or use.area_ratio is None:
        return "The rails lie in a plane: there is no installation space to compare with."
    return (
        f"Rails span {box.x_m:g} x {box.y_m:g} x {box.z_m:g} m = {box.volume_m3:.4g} m^3: {use.volume_ratio:.3f} of it "
        f"usable together; across the rails, {use.area_ratio:.3f} of {box.frame_m2:.4g} m^2"
    )


def workspace_data(machine: Machine, setting: WorkspaceSetting, rows: list[WorkspaceRow]) -> dict[str, object]:
    """Put the setting, all rows, and the ratios of the union to all-left and all-right into a mapping, unrounded."""
    ratios = {row.mode: row.union_ratio for row in rows}
    return {
        "setting": {
            "rx_rad": setting.rx_rad,
            "rz_rad": setting.rz_rad,
            "kappa_max": setting.kappa_max,
            "link_link_m": machine.link_link_m,
            "link_rail_m": machine.link_rail_m,
            "travel_m": machine.travel_m,
            "strokes_m": machine.strokes_m,
            **{cone.key: cone.half_angle_deg for cone in machine.joint_cones},
            "step_m": setting.step_m,
            "coarse_step_m": 2.0 * setting.step_m,
        },
        "installation": space_figures(
            SpaceUse(setting, installation_of(machine), rows[-1].volume_m3, rows[-1].area_m2)
        ),
        "rows": rows,
        "union_over_lll": ratios["LLL"],
        "union_over_rrr": ratios["RRR"],
    }
