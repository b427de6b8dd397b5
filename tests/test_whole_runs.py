"""Measurements of whole runs and of the set-up: what is written of them, and that they measure."""

from pathlib import Path
from typing import Any

import pytest

from pipeline.artifacts import json_bytes
from tests.benchmarks.history import read_history, runs_page, runs_picture
from tests.benchmarks.setting_up import setup_page
from tests.benchmarks.whole_runs import measure

ROOT = Path(__file__).parents[1]
HOST = {
    "date": "2026-02-03T04:05",
    "cpu": "a processor",
    "cores": 2,
    "load_before": 0.5,
    "versions": {"python": "3.11"},
}


def _measured(wall_s: float, **names: float) -> dict[str, Any]:
    """Make what is measured of runs, each as much longer as is given."""
    stages = {"regions": 1.0, "figures": 2.0}
    runs = {
        name: {"wall_s": factor * wall_s, "cpu_s": 2.0 * wall_s, "peak_mb": 700.0, "stages": stages}
        for name, factor in names.items()
    }
    return {"start": {"import_s": 0.05, "help_s": 0.25}, "runs": runs}


@pytest.fixture
def history(tmp_path: Path) -> dict[str, dict[str, Any]]:
    """Write and read the files of two dates, the later one first."""
    later = {"host": HOST, "repeats": 5, **_measured(10.0, agder=2.0, quick=1.0)}
    later["before"] = _measured(25.0, agder=2.0, quick=1.0)
    (tmp_path / "2026-02-03.json").write_bytes(json_bytes(later))
    (tmp_path / "2026-01-02.json").write_bytes(json_bytes({"host": HOST, "repeats": 5, **_measured(30.0, quick=1.0)}))
    return read_history(tmp_path)


def test_the_page_has_every_date_and_the_last_beside_what_was_before(history: dict[str, dict[str, Any]]) -> None:
    """Dates are in their order; a configuration that was not measured is a dash; ratios are after over before."""
    page = runs_page(history)
    assert page.index("| 2026-01-02 | - | 30.0 (60.0) |") < page.index("| 2026-02-03 | 20.0 (20.0) | 10.0 (20.0) |")
    assert "| quick | 10.0 | 20.0 | 700 | 25.0 | 50.0 | 700 | 0.40 | 0.40 |" in page
    assert "| agder, before | 1.00 | 0.00 | 0.00 | 0.00 | 0.00 | 2.00 |" in page


def test_all_dates_are_drawn(history: dict[str, dict[str, Any]]) -> None:
    """The picture is a PNG, of one date as well as of more."""
    one = dict(list(history.items())[:1])
    assert all(runs_picture(dates).startswith(b"\x89PNG") for dates in (history, one))


def test_a_checkout_is_measured() -> None:
    """Seconds to import the package and to show its help are those of other processes."""
    start = measure({"after": ROOT}, (), 1)["after"]["start"]
    assert set(start) == {"import_s", "help_s"}
    assert min(start.values()) > 0.0


def test_set_ups_are_compared_by_their_medians() -> None:
    """Each has its ratio to the slowest, and its range."""
    page = setup_page(HOST, {"new": [10.0, 12.0, 11.0], "old": [44.0, 40.0, 50.0]})
    assert "| new | 11.0 | 0.25 | 10.0 to 12.0 |" in page
    assert "| old | 44.0 | 1.00 | 40.0 to 50.0 |" in page
