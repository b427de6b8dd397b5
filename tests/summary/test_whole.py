"""The whole of `summary.json`."""

from pipeline.config import Config
from pipeline.summary.whole import summarise

LENGTHS, TIMES = {"length_ratio": 1.2}, {"motion_s": 6.0}


def test_the_quality_of_a_timed_motion_is_the_path_s(quick_config: Config) -> None:
    """What refining and what timing know of it stand together, once, and the sections given stay as they are."""
    sections = {
        "path": {"kappa_max": 30.0, "quality": LENGTHS},
        "trajectory": {"duration_s": 6.5, "quality": TIMES},
    }
    summary = summarise(quick_config, sections)
    assert summary["path"] == {"kappa_max": 30.0, "quality": {**LENGTHS, **TIMES}}
    assert summary["trajectory"] == {"duration_s": 6.5}
    assert sections["trajectory"]["quality"] == TIMES
    assert list(summary)[-2:] == ["path", "trajectory"]


def test_what_the_drives_feel_is_a_part_of_its_own(quick_config: Config) -> None:
    """Timing finds it; it follows the trajectory, and sections given stay as they are."""
    sections = {"trajectory": {"duration_s": 6.5, "drives": {"status": "done"}}, "figures": {"count": 3}}
    summary = summarise(quick_config, sections)
    assert list(summary)[-3:] == ["trajectory", "drives", "figures"]
    assert summary["drives"] == {"status": "done"}
    assert summary["trajectory"] == {"duration_s": 6.5}
    assert "drives" in sections["trajectory"]
    assert "drives" not in summarise(quick_config, {"trajectory": {"status": "failed"}})


def test_the_workspace_is_a_part_of_its_own(quick_config: Config) -> None:
    """It is found with the regions, and follows them."""
    sections = {"regions": {"count": 9, "workspace": {"status": "done"}}, "route": {"status": "skipped"}}
    summary = summarise(quick_config, sections)
    assert list(summary)[-3:] == ["regions", "workspace", "route"]
    assert summary["regions"] == {"count": 9}


def test_a_run_without_time_has_the_rest(quick_config: Config) -> None:
    """Without a trajectory, or with one of an earlier version, the path has what it knows itself."""
    path = {"kappa_max": 30.0, "quality": LENGTHS}
    for timed in ({"status": "skipped"}, {"status": "failed", "reason": "too heavy"}, {"duration_s": 6.5}):
        assert summarise(quick_config, {"path": path, "trajectory": timed})["path"] == path
    assert summarise(quick_config, {"path": {"status": "skipped"}})["path"] == {"status": "skipped"}
