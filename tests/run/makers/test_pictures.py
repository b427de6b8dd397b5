"""Figures of a run: when each can be drawn."""

import pytest

from pipeline.figures import FIGURES
from pipeline.run.makers.pictures import last_stage
from pipeline.stage import STAGES, Stage


@pytest.mark.parametrize(
    ("name", "stage"),
    [
        ("regions", Stage.REGIONS),
        ("machine", Stage.ROUTE),
        ("route", Stage.REFINE),
        ("proof", Stage.CERTIFY),
        ("pose_error", Stage.CERTIFY),
        ("pose", Stage.RETIME),
    ],
)
def test_a_figure_waits_for_all_that_is_drawn_in_it(name: str, stage: Stage) -> None:
    """The route's picture has the refined path, too: it is drawn after stage two."""
    assert {figure.name: last_stage(figure) for figure in FIGURES}[name] is stage


def test_every_figure_is_drawn_before_its_stage_ends() -> None:
    """No figure needs the stage that makes figures."""
    assert {last_stage(figure) for figure in FIGURES} <= set(STAGES[:-1])
