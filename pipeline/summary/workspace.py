"""The workspace against the installation space, in the summary."""

from typing import TYPE_CHECKING

from pipeline.summary.section import WORKSPACE, Section

if TYPE_CHECKING:
    from pipeline.workspace.installation import SpaceUse


def space_figures(use: "SpaceUse") -> Section:
    """Give what is used, what is taken up, and their ratios; null where there is nothing to divide by."""
    installation = use.installation
    return {
        "kappa_max": use.setting.kappa_max,
        "step_m": use.setting.step_m,
        "volume_m3": use.volume_m3,
        "area_m2": use.area_m2,
        "installation_m3": installation.volume_m3,
        "frame_m2": installation.frame_m2,
        "footprint_m2": installation.footprint_m2,
        "volume_ratio": use.volume_ratio,
        "area_ratio": use.area_ratio,
        "volume_per_footprint_m": use.volume_per_footprint_m,
    }


def workspace_part(use: "SpaceUse") -> Section:
    """Give the figures as a part that `summary.whole` puts beside those of the stages."""
    return {WORKSPACE: {"status": "done", **space_figures(use)}}
