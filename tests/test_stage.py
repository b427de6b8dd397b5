"""The stages and their order."""

from pipeline.stage import STAGES, Stage


def test_every_stage_knows_what_is_before_and_after_it() -> None:
    """Every stage knows what is before and after it."""
    assert Stage.REGIONS.earlier == ()
    assert Stage.ROUTE.later == (Stage.REFINE, Stage.CERTIFY, Stage.RETIME, Stage.FIGURES)
    assert all((*stage.earlier, stage, *stage.later) == STAGES for stage in STAGES)
