"""What the page says: the nearest limit by name, reasons as they are, and nothing that is obeyed as HTML."""

import re
from pathlib import Path

from pipeline.config import Config
from pipeline.machine import Machine
from pipeline.show.posture import first_posture, place_machine
from pipeline.show.words import (
    message_html,
    modes_html,
    next_html,
    pose_html,
    readings_html,
    task_html,
    verdict_html,
)


def text_of(html: str) -> str:
    """Remove the tags."""
    return re.sub(r"<[^>]*>", " ", html)


def test_a_good_pose_names_its_nearest_limit(quick_config: Config, machine: Machine) -> None:
    """The verdict names the limit that the table has first, with its margin."""
    posture = first_posture(quick_config, machine)
    assert "Within all limits." in verdict_html(posture)
    assert f"<b>{posture.nearest.name}</b>" in verdict_html(posture)
    assert f"{posture.nearest.margin:.4f} m left" in verdict_html(posture)
    rows = readings_html(posture.readings).split("<tr")[2:]
    assert len(rows) == len(posture.readings)
    assert f">{posture.nearest.name}<" in rows[0]
    assert f"{posture.samples.kappa[0]:.3f}" in pose_html(posture)


def test_a_refused_pose_says_why(quick_config: Config, machine: Machine) -> None:
    """All reasons are there; out of reach, also that the machine stays."""
    first = first_posture(quick_config, machine)
    tilted = place_machine(quick_config, machine, first.asked.model_copy(update={"rx_deg": 34.0}), first.samples)
    assert "rx_deg is 34; allowed is at most 30" in verdict_html(tilted)
    assert "stays" not in verdict_html(tilted)
    far = place_machine(quick_config, machine, first.asked.model_copy(update={"y_m": 3.0}), first.samples)
    assert "Out of reach." in verdict_html(far)
    assert "stays where it was" in verdict_html(far)


def test_text_of_others_is_not_obeyed() -> None:
    """Tags in messages, names and commands are shown as they are."""
    for html in (message_html("<script>\nx"), next_html("gantry-tau run '<b>.yaml'", Path("<i>"), True)):
        assert "<script>" not in html
        assert "<b>.yaml" not in html
    assert "&lt;script&gt;<br>x" in message_html("<script>\nx")


def test_the_way_to_a_csv_is_said() -> None:
    """Without a trajectory, how to get one; with it, where it is."""
    before, after = (text_of(next_html("gantry-tau run a.yaml", Path("results/a"), timed)) for timed in (False, True))
    assert "gantry-tau run a.yaml" in before
    assert "results/a/trajectory.csv" in after
    assert "gantry-tau export results/a --format csv" in after


def test_task_and_modes(quick_config: Config, vary) -> None:
    """Entries are listed with their values, refusals above all; the present mode stands out."""
    config = vary(quick_config, {"task.avoid": [{"y_m": [0.1, 0.2]}]})
    assert "check accepts this task" in task_html(config, [])
    refused = text_of(task_html(config, ["task.goal: is <wrong>"]))
    assert "check refuses this task" in refused
    assert "avoid[0]" in refused
    assert "y_m 0.1 to 0.2" in refused
    assert "<b>LLL (23, +)</b>, RRL (800, −)" in modes_html({"LLL": (23.1, 1.0), "RRL": (800.0, -1.0)}, "LLL")
    assert "No working mode" in modes_html({}, "LLL")
