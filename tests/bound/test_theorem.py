"""Tests of the theorem: the identity in exact arithmetic, its hypothesis, and the signs at both ends."""

from collections.abc import Callable
from fractions import Fraction

import pytest
from flint import fmpq, fmpq_mat
from hypothesis import given, settings
from hypothesis import strategies as st

from pipeline.bound.theorem import Theorem, apply_theorem, decimal, parallelogram_widths
from pipeline.config import Config
from pipeline.machine.geometry import build_machine, link_vectors
from pipeline.route.regions.endpoints import task_endpoints

Vary = Callable[..., Config]
WITHOUT_TILT = {"task.locked_axes": ["rx", "rz"]}
rationals = st.fractions(-3, 3, max_denominator=12)
vectors = st.tuples(rationals, rationals, rationals)


def _cross(a: list[Fraction], b: list[Fraction]) -> list[Fraction]:
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def _det(rows: list[list[Fraction]]) -> Fraction:
    det = fmpq_mat([[fmpq(x.numerator, x.denominator) for x in row] for row in rows]).det()
    return Fraction(int(det.p), int(det.q))


def _theorem(config: Config) -> Theorem:
    machine = build_machine(config.machine)
    return apply_theorem(config, machine, task_endpoints(config, machine))


@settings(max_examples=25)
@given(
    vectors,
    st.tuples(*[vectors] * 4),
    st.tuples(*[vectors] * 4),
    st.fractions(Fraction(1, 5), 3, max_denominator=9),
)
def test_the_determinant_factors_for_every_machine(
    turn_and_widths: tuple[Fraction, ...],
    points: tuple[tuple[Fraction, ...], ...],
    joints: tuple[tuple[Fraction, ...], ...],
    length: Fraction,
):
    """The determinant: det H = h_2 h_3 F D / L^3 holds exactly, whatever joints, triangle and turn about y."""
    half, h2, h3 = turn_and_widths
    c, s = (1 - half**2) / (1 + half**2), 2 * half / (1 + half**2)

    def turned(a: tuple[Fraction, ...]) -> list[Fraction]:
        return [c * a[0] + s * a[2], a[1], c * a[2] - s * a[0]]

    def beside(a: list[Fraction], width: Fraction) -> list[Fraction]:
        return [a[0], a[1] + width, a[2]]

    arms = [turned(a) for a in points]
    carts = [list(joint) for joint in joints]
    six = [arms[0], arms[1], beside(arms[1], h2), arms[2], beside(arms[2], h3), arms[3]]
    ends = [carts[0], carts[1], beside(carts[1], h2), carts[2], beside(carts[2], h3), carts[3]]
    v = [[a - b for a, b in zip(arm, cart, strict=True)] for arm, cart in zip(six, ends, strict=True)]
    H = [x + [m / length for m in _cross(arm, x)] for x, arm in zip(v, six, strict=True)]
    D = _det([H[k][:3] + [H[k][4] * length] for k in (0, 1, 3, 5)])
    F = v[1][0] * v[3][2] - v[1][2] * v[3][0]
    assert _det(H) == h2 * h3 * F * D / length**3


def test_no_path_exists_without_tilt(quick_config: Config, vary: Vary):
    """All left to all right: F is positive at the start and negative at the goal, far from zero."""
    theorem = _theorem(vary(quick_config, WITHOUT_TILT))
    assert theorem.no_path
    assert theorem.start is not None
    assert theorem.goal is not None
    assert theorem.start[0] > 0.9
    assert theorem.goal[1] < -0.9
    assert "no path exists" in theorem.sentence


def test_no_tilt_is_the_same_as_locked_tilts(quick_config: Config, vary: Vary):
    """A largest tilt of zero is a machine without tilt."""
    assert _theorem(vary(quick_config, {"task.tilt_max_deg": 0.0})).no_path


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"task.locked_axes": ["rx"]},
        {**WITHOUT_TILT, "machine.links.l2b.platform_point_m": [0.09, 0.4501, -0.07]},
        {**WITHOUT_TILT, "machine.links.l3b.cart_offset_m": [0.0, 0.279, 0.0]},
        {**WITHOUT_TILT, "machine.links.l3b.cart_offset_m": [0.001, 0.28, 0.0]},
        {**WITHOUT_TILT, "machine.rails.0.slopes": (0.0, 0.0001)},
    ],
)
def test_other_machines_are_not_claimed(quick_config: Config, vary: Vary, changes: dict[str, object]):
    """With tilt, parallelograms that are none, or rails off X, nothing is proven, and the reason is given."""
    theorem = _theorem(vary(quick_config, changes))
    assert not theorem.no_path
    assert theorem.unmet
    assert "does not apply" in theorem.sentence


def test_an_end_on_the_same_side_proves_nothing(quick_config: Config, vary: Vary):
    """Where F has one sign at both ends, the theorem is silent."""
    goal = {"x_m": 1.02, "y_m": 0.4, "z_m": 0.9, "mode": "LLL"}
    theorem = _theorem(vary(quick_config, {**WITHOUT_TILT, "task.goal": goal}))
    assert not theorem.no_path
    assert "proves nothing" in theorem.sentence


def test_triangle_need_not_be_right_angled_or_on_the_axis(quick_config: Config, vary: Vary):
    """The triangle is no part of the hypothesis: it only has to close."""
    changes = {
        "machine.links.l3a.platform_point_m": [0.01, 0.1, 0.0],
        "machine.links.l3b.platform_point_m": [0.01, 0.38, 0.0],
    }
    assert _theorem(vary(quick_config, {**WITHOUT_TILT, **changes})).no_path
    assert _theorem(vary(quick_config, {**WITHOUT_TILT, "machine.links.l3c.length_m": 1.26})).no_path


def test_decimals_are_meant(agder_config: Config):
    """0.45 - 0.17 is 0.28 as it is written, though not in floats."""
    assert decimal(0.45) - decimal(0.17) == decimal(0.28)
    assert parallelogram_widths(agder_config.machine) == (Fraction(28, 100), Fraction(28, 100))


def test_bounds_of_f_hold_what_floats_find(quick_config: Config, vary: Vary):
    """F from the positions of joints in floats lies within the bounds, or as near as ry is bounded."""
    config = vary(quick_config, WITHOUT_TILT)
    machine = build_machine(config.machine)
    ends = task_endpoints(config, machine)
    theorem = apply_theorem(config, machine, ends)
    for bounds, end in zip((theorem.start, theorem.goal), ends, strict=True):
        v = link_vectors(machine, end.pose, end.q_m[:3])
        F = float(v[1, 0] * v[3, 2] - v[1, 2] * v[3, 0]) / (1.09 * 1.25)
        assert bounds is not None
        assert bounds[0] - 1e-12 <= F <= bounds[1] + 1e-12
