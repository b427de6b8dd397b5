"""The workspace in the summary."""

from pipeline.summary.workspace import workspace_part
from pipeline.workspace.installation import Installation, SpaceUse
from pipeline.workspace.usable import WorkspaceSetting

SETTING = WorkspaceSetting(kappa_max=30.0, step_m=0.1)


def test_every_figure_has_its_key() -> None:
    """With the setting it is for."""
    part = workspace_part(SpaceUse(SETTING, Installation(2.0, 0.5, 1.5), volume_m3=3.0, area_m2=1.5))
    assert part == {
        "workspace": {
            "status": "done",
            "kappa_max": 30.0,
            "step_m": 0.1,
            "volume_m3": 3.0,
            "area_m2": 1.5,
            "installation_m3": 1.5,
            "frame_m2": 0.75,
            "footprint_m2": 1.0,
            "volume_ratio": 2.0,
            "area_ratio": 2.0,
            "volume_per_footprint_m": 3.0,
        }
    }


def test_what_cannot_be_divided_is_null() -> None:
    """All rails in a plane."""
    section = workspace_part(SpaceUse(SETTING, Installation(2.0, 0.0, 1.5), 3.0, 1.5))["workspace"]
    assert [section[key] for key in ("volume_ratio", "area_ratio", "volume_per_footprint_m")] == [None] * 3
