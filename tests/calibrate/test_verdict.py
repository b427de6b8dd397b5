"""Whether a calibration may be believed."""

from collections.abc import Callable

import numpy as np

from pipeline.calibrate import Setting, Verdict, calibrate, judge
from pipeline.calibrate.model.parameters import CHOICES, USUAL
from pipeline.calibrate.verdict import measured_modes
from pipeline.config import Config
from tests.calibrate.conftest import REFLECTORS_M, Seen


def judged(config: Config, seen: Seen, **setting: object) -> Verdict:
    """Calibrate, and judge."""
    return judge(calibrate(config, REFLECTORS_M[:2], seen.simulated.poses, Setting(**setting)))  # type: ignore[arg-type]


def test_a_good_calibration_is_accepted(see: Callable[..., Seen], quick_config: Config):
    """Its rank is all that measurements can tell, and chi-square is what is expected."""
    verdict = judged(quick_config, see())
    assert verdict.accepted
    assert verdict.reasons == ()
    assert (verdict.directions, verdict.gauges, verdict.rank) == (68, 21, 47)
    assert verdict.from_data < verdict.rank
    assert 1e-3 < verdict.probability < 1.0 - 1e-3


def test_too_few_poses_do_not_determine_a_machine(see: Callable[..., Seen], quick_config: Config):
    """Eight poses say so, with the modes they are in and what to do."""
    seen = see(poses=8)
    verdict = judged(quick_config, seen)
    assert not verdict.accepted
    assert "determine 41 of the 47 directions" in verdict.reasons[0]
    assert "more working modes (there are" in verdict.reasons[0]
    assert "): the 4 of --next 4 suffice" in verdict.reasons[0]
    less = judged(quick_config, seen, fit=("platform", "reflectors"))
    assert less.rank == less.directions - less.gauges
    assert not any("determine" in reason for reason in less.reasons)


def test_rails_that_are_not_parallel_are_told(see: Callable[..., Seen], quick_config: Config):
    """The parallel model is refused, and its reason are the slopes, which a fit of directions finds."""
    seen = see(direction_std_rad=4e-4, seed=1)
    verdict = judged(quick_config, seen)
    assert not verdict.accepted
    assert "Rails that are not parallel do: slopes along Y and Z in mrad are rail 1" in verdict.reasons[0]
    wide = judged(quick_config, seen, fit=CHOICES, prior={"directions": 1e-3})
    assert wide.accepted
    assert (wide.directions, wide.gauges, wide.rank) == (74, 23, 51)


def test_what_else_is_wrong_is_told(see: Callable[..., Seen], quick_config: Config):
    """Outliers, kinds that were not fitted, a machine farther off, and more noise: each with what to change."""
    outliers = judged(quick_config, see(outliers=0.04))
    assert "points are outliers (row" in outliers.reasons[0]
    assert "--robust rejects them" in outliers.reasons[0]
    off = see(scale_std=1e-3)
    unscaled = tuple(key for key in USUAL if key != "scales")
    missing = judged(quick_config, off, fit=unscaled, prior={"scales": 1e-3})
    assert "With scales fitted, one does" in missing.reasons[0]
    farther = judged(quick_config, see(geometry_std_m=8e-4))
    assert "give larger deviations (--prior 0.0005, with which one does)" in farther.reasons[0]
    lengths = dict.fromkeys(("platform", "offsets", "rails", "lengths", "zeros", "reflectors"), 5e-4)
    assert judged(quick_config, see(geometry_std_m=8e-4), prior=lengths).accepted
    noisy = judged(quick_config, see(noise_m=2e-4))
    stated = float(noisy.reasons[0].split("noise of ")[1].split(" um")[0])
    assert abs(stated - 200.0) < 30.0
    noise_m = float(noisy.reasons[0].split("(--noise ")[1].split(",")[0])
    assert judged(quick_config, see(noise_m=2e-4), noise_m=noise_m).accepted


def test_modes_are_counted(see: Callable[..., Seen], quick_config: Config):
    """Every pose is in a working mode, and their numbers add up."""
    poses = see(poses=20).simulated.poses
    modes = measured_modes(calibrate(quick_config, REFLECTORS_M[:2], poses, Setting()).identification)
    assert sum(modes.values()) == 20
    assert {"LLL", "RRR"} < set(modes)
    assert np.all(np.array(list(modes.values())) > 0)
