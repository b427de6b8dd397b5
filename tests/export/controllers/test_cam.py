"""Cams over time: as CODESYS writes them, with as few points as the tolerance allows."""

import re
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.interpolate import BPoly

from pipeline.errors import UsageError
from pipeline.export import ExportOptions, ExportRequest
from pipeline.export.controllers.cam import format_cam, hermite, read_cam, thinned
from pipeline.export.formats import LengthUnit
from pipeline.machine.geometry import ACTUATORS
from pipeline.retime import TrajectorySamples

LIMITS = np.array([2.0, 2.0, 2.0, 0.5, 0.5])


def test_the_polynomials_are_those_of_scipy() -> None:
    """Position, velocity, acceleration and jerk between points, by another program's polynomials of degree five."""
    generator = np.random.default_rng(1)
    t, points = np.cumsum(generator.uniform(0.01, 0.1, 6)), generator.uniform(-1.0, 1.0, (6, 3))
    oracle = BPoly.from_derivatives(t, points)
    at = np.linspace(t[0], t[-1], 200)[:-1]
    found = hermite(t, points, at)
    for derivative in range(4):
        exact = oracle(at, nu=derivative)
        assert found[:, derivative] == pytest.approx(exact, abs=1e-9 * np.abs(exact).max())


@pytest.mark.parametrize("tolerance_m", [1e-8, 1e-6, 1e-4])
def test_points_are_few_and_keep_the_tolerance(reference: TrajectorySamples, tolerance_m: float) -> None:
    """The motion read back is as near as asked for, from a small part of the 707 rows."""
    options = ExportOptions(tolerance_m=tolerance_m)
    text = format_cam(ExportRequest(reference, LIMITS, ACTUATORS, options))
    motion = read_cam(text)
    assert len(motion.t_s) == len(reference)
    assert np.abs(motion.q_m - reference.q_m).max() <= tolerance_m + 1e-11
    counts = [int(count) for count in re.findall(r"nElements := (\d+)", text)]
    assert max(counts) < {1e-8: 250, 1e-6: 80, 1e-4: 35}[tolerance_m]


def test_each_point_is_as_far_as_it_can_be(reference: TrajectorySamples) -> None:
    """The next row after a chosen one would break the tolerance."""
    axis = np.stack([reference.q_m[:, 0], reference.qd_mps[:, 0], reference.qdd_mps2[:, 0]], axis=1)
    t, tolerance = reference.t_s, 1e-6
    rows = thinned(t, axis, tolerance)
    assert rows[0] == 0
    assert rows[-1] == len(t) - 1
    for first, last in pairwise(rows[:-1].tolist()):
        ends = [first, last + 1]
        assert (
            np.abs(hermite(t[ends], axis[ends], t[first : last + 1])[:, 0] - axis[first : last + 1, 0]).max()
            > tolerance
        )


def test_the_declaration_is_as_codesys_generates_it(make_samples) -> None:
    """An array of points and an MC_CAM_REF of type 3 per joint, in identifiers that IEC 61131 allows."""
    names = ("slide/a", "slide.b", "c__d", "e", "f")
    text = format_cam(ExportRequest(make_samples(0.01), LIMITS, names, ExportOptions(length=LengthUnit.MM)))
    assert re.findall(r"(\w+): MC_CAM_REF", text) == ["Cam_slide_a", "Cam_slide_b", "Cam_c_d", "Cam_e", "Cam_f"]
    for name, most, count in re.findall(r"(\w+)_points: ARRAY\[0\.\.(\d+)\].*?nElements := (\d+)", text, re.DOTALL):
        assert int(most) + 1 == int(count) == len(re.findall("dX", text.split(f"{name}_points: ")[1].split("];")[0]))
        assert "byType := 3, xStart := 0.0, xEnd := 0.2" in text
        assert f"pce := ADR({name}_points), xPartofLM := TRUE);" in text
    assert "e-" not in re.sub(r"\(\*.*?\*\)", "", text, flags=re.DOTALL).split("VAR_GLOBAL")[1].split("END_VAR")[0]
    assert "dX := 0.000000000000, dY := 300.000000000000, dV := 0.000000000000, dA := 0.000000000000" in text


def test_names_that_are_no_different_identifiers_are_refused(make_samples) -> None:
    """IEC 61131 knows no punctuation in names, and no case."""
    with pytest.raises(UsageError, match=r"two joints are called the same.*\n.*export.joint_names"):
        format_cam(ExportRequest(make_samples(0.01), LIMITS, ("a/b", "A.b", "c", "d", "e")))


def test_more_points_than_codesys_counts_are_refused(make_samples) -> None:
    """`nElements` is an INT; only a motion that no polynomial meets takes as many."""
    samples = make_samples(0.2 / 32_800)
    noise = np.random.default_rng(1).normal(size=samples.qdd_mps2.shape)
    request = ExportRequest(replace(samples, qdd_mps2=noise), LIMITS, ACTUATORS, ExportOptions(tolerance_m=0.0))
    with pytest.raises(UsageError, match=r"c1 takes 32,801 points; MC_CAM_REF has at most 32,767.*\n.*--tolerance"):
        format_cam(request)
