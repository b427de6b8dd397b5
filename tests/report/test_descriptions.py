"""What plots show is also said, in the numbers of the report."""

from dataclasses import replace

import numpy as np

from pipeline.machine.geometry import MODES
from pipeline.report import Report
from pipeline.report.descriptions import describe_plots


def test_every_plot_is_described_by_its_own_numbers(report: Report) -> None:
    """Duration, places, working modes, extremes of kappa and the proven bound are those of motion and proof."""
    motion, proof = report.motions[0], report.proof
    assert proof is not None
    described = describe_plots(report)
    assert set(described) == {"machine", "map", "timeline", "proof"}
    x, y, z = motion.pose[-1, :3]
    assert f"In {motion.t_s[-1]:.2f} s the TCP moves from" in described["machine"]
    assert f"to ({x:.2f}, {y:.2f}, {z:.2f}) m" in described["machine"]
    assert f"between {motion.kappa.min():.1f} and {motion.kappa.max():.1f}" in described["map"]
    assert f"of the {len(motion.maps.titles)} maps" in described["map"]
    worst = int(np.argmax(motion.kappa))
    assert f"κ peaks at {motion.kappa[worst]:.1f} at {motion.t_s[worst]:.2f} s" in described["timeline"]
    for mode in set(motion.modes.tolist()):
        assert MODES[mode] in described["timeline"]
    assert f"over {len(proof.bound)} boxes, at most {proof.bound.max():.2f}" in described["proof"]


def test_the_nearest_bodies_are_described(bodies_report: Report, report: Report) -> None:
    """Pair, distance and time of the closest approach; nothing of the kind without bodies."""
    motion = bodies_report.motions[0]
    nearest = [motion.nearest_at(i) for i in range(len(motion.t_s))]
    worst = int(np.argmin([distance_m for _, distance_m in nearest]))
    pair, distance_m = nearest[worst]
    text = (
        f"{bodies_report.scene.pair_names[pair]} come closest: {1e3 * distance_m:.1f} mm at {motion.t_s[worst]:.2f} s"
    )
    assert text in describe_plots(bodies_report)["machine"]
    assert "bodies" not in describe_plots(report)["machine"]


def test_what_is_not_drawn_is_not_described(report: Report) -> None:
    """Without motions there is the proof alone, and boxes without a bound are counted."""
    assert report.proof is not None
    open_ended = replace(report.proof, bound=np.array([30.0, np.inf]))
    described = describe_plots(replace(report, motions=(), proof=open_ended))
    assert set(described) == {"proof"}
    assert "missing in 1 of them" in described["proof"]
    assert describe_plots(replace(report, motions=(), proof=None)) == {}
