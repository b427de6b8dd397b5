"""Motions of an atlas: what each depends on."""

import pytest

from pipeline.config import Config
from pipeline.run.atlas.motions import motion_fingerprint
from pipeline.run.stage_specs import SPECS


@pytest.mark.parametrize(
    ("changes", "last", "same"),
    [
        ({"retime.period_s": 0.002}, "retime", False),
        ({"retime.period_s": 0.002}, "certify", True),
        ({"certify.kappa_excess": 0.001}, "certify", False),
        ({"certify.kappa_excess": 0.001}, "refine", True),
        ({"refine.smoothness": 0.5}, "refine", False),
        ({"figures.pdf": True}, "retime", True),
        ({"retime.period_s": 0.002}, "", False),
    ],
)
def test_a_motion_depends_on_its_stages(changes: dict, last: str, same: bool, cell: Config, vary) -> None:
    """Options of later stages leave it as it is; all count where it is unknown how far it got."""
    before, after = (motion_fingerprint(SPECS, config, last) for config in (cell, vary(cell, changes)))
    assert (before == after) == same
