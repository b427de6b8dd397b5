"""The certificate's bounds of boxes to avoid, and their independent check."""

import pathlib
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipeline.certify import certify_path, prove_path
from pipeline.certify.chain import Chain, close_chain
from pipeline.certify.examiner import build_error_examiner
from pipeline.certify.problem import build_problem
from pipeline.certify.recheck import verify
from pipeline.certify.recheck.arithmetic.chain import EvaluatedChain, evaluate_chain
from pipeline.certify.recheck.claims import errors
from pipeline.certify.recheck.claims.controlled.avoided import measure
from pipeline.certify.result import proven_chain
from pipeline.config import BoxConfig, Config
from pipeline.inclusion.closure import working_precision
from pipeline.inclusion.distances.avoidance import least_outside
from pipeline.inclusion.proven_box import ProvenBox
from pipeline.inclusion.uncertainty import CERTAIN, of_actuators
from pipeline.limits import error_proven_limits
from pipeline.limits.avoid import PROOF_SLACK, Box
from pipeline.machine import Machine
from pipeline.machine.kinematics import newton
from pipeline.machine.pose import CONTROLLED
from pipeline.refine import Path
from tests.certify.paths import START, ends_of, pose_path, state
from tests.certify.runs import Data, forge, write_run
from tests.certify.runs import check as check_run

KEY = "avoided_by"
KEYS = ("x_m", "y_m", "z_m", "rx_deg", "rz_deg")
S = np.linspace(0.0, 1.0, 2_001)
AWAY = np.array([0.02, 0.03, -0.02, 0.05, -0.03])
EPS_M = 2e-4


def bent_path(machine: Machine, away: np.ndarray = AWAY) -> Path:
    """Go there and halfway back, each coordinate in a bend of its own."""
    s = np.linspace(0.0, 1.0, 21)[:, None]
    return pose_path(machine, START + away * np.sin(s * [2.0, 2.6, 1.5, 3.0, 2.3]), 0, 21)


@pytest.fixture(scope="module")
def bent(machine: Machine) -> Path:
    """Make the bent path."""
    return bent_path(machine)


def close(path: Path, eps_m: float) -> tuple[Chain, list[ProvenBox]]:
    """Prove a path for errors of all actuators, and keep the boxes."""
    kept: list[ProvenBox] = []

    def keep(box: ProvenBox) -> tuple[()]:
        kept.append(box)
        return ()

    problem = replace(build_problem(path.machine, path, 1e-3), uncertainty=of_actuators(np.ones(5))(eps_m))
    chain = close_chain(problem, keep)
    assert chain.failure is None
    return chain, [box for box in kept if any(box.inclusion is one for one in chain.inclusions)]


@pytest.fixture(scope="module")
def proofs(bent: Path) -> list[tuple[EvaluatedChain, list[ProvenBox], np.ndarray]]:
    """Prove the bent path without and with errors; sampled poses, in corners of the errors where there are any."""
    found = []
    with working_precision(64):
        for eps_m in (0.0, EPS_M):
            chain, boxes = close(bent, eps_m)
            uncertainty = of_actuators(np.ones(5))(eps_m) if eps_m else CERTAIN
            (segment,) = evaluate_chain(bent.machine, bent, proven_chain(chain, uncertainty))
            poses = [bent.pose(S)]
            for signs in np.random.default_rng(1).choice([-1.0, 1.0], (6 if eps_m else 0, 5)):
                poses.append(newton(bent.machine, bent.q(S) + eps_m * signs, poses[0])[0])
            found.append((segment, boxes, np.array(poses)[..., CONTROLLED]))
    return found


def box_config(sides: dict[int, tuple[float, float]]) -> BoxConfig:
    """Write a box with some coordinates, in metres and radians, as a configuration does."""
    degrees = {k: tuple(np.rad2deg(ends).tolist()) if k > 2 else ends for k, ends in sides.items()}
    return BoxConfig.model_validate({KEYS[k]: ends for k, ends in degrees.items()})


sides = st.dictionaries(
    st.integers(0, 4),
    st.tuples(st.floats(-0.03, 0.05), st.floats(0.001, 0.03)),
    min_size=1,
    max_size=4,
)


@given(sides)
@settings(max_examples=10, deadline=None)
def test_bounds_are_below_all_samples_and_near_them(
    agder_config: Config, bent: Path, proofs: list, found: dict[int, tuple[float, float]]
) -> None:
    """Of random boxes, with errors of the drives and without; the check finds no less than is stated, nor too much."""
    config = box_config({k: (START[k] + first, START[k] + first + width) for k, (first, width) in found.items()})
    box, task = Box.of(config), agder_config.task.model_copy(update={"avoid": (config,)})
    asked = agder_config.model_copy(update={"task": task})
    with working_precision(64):
        for segment, boxes, poses in proofs:
            bounds = [least_outside(one, box.low, box.high) for one in boxes]
            sampled = -box.depth_m(poses).max(axis=0)
            for one, bound in zip(boxes, bounds, strict=True):
                interval = one.inclusion.box
                assert bound <= sampled[(interval.first <= S) & (interval.last >= S)].min(initial=np.inf)
            again = measure(asked, bent.machine, segment)[0, 0]
            assert min(bounds) - PROOF_SLACK <= again <= sampled.min()
            assert min(bounds) >= sampled.min() - (5e-3 if segment.inclusions.following else 5e-4)


def grazing(machine: Machine, depth: float) -> tuple[Path, list[dict[str, object]]]:
    """Give a path that is inside a box by `depth` in its middle alone, and the box: two coordinates, open sides."""
    s = np.linspace(0.0, 1.0, 41)
    path = pose_path(machine, START + np.outer(4.0 * s * (1.0 - s), [0.0, 0.03, -0.02, 0.03, 0.0]), 0)
    top = path.pose(np.array([0.5]))[0]
    sides = {"y_m": [float(top[1]) - depth, float(top[1]) + 0.1], "x_m": [float(top[0]) - 0.05, float(top[0]) + 0.05]}
    return path, [{"z_m": [3.0, 4.0]}, sides]


@pytest.mark.parametrize("depth", [2e-5, 1e-3])
def test_a_path_that_grazes_a_box_is_refused_by_proof_and_check(
    wide: Config, machine: Machine, vary: Callable, depth: float
) -> None:
    """The search says which box, and where; what was proven of a smaller box does not pass for the larger one."""
    path, boxes = grazing(machine, depth)
    inside = Box.of(BoxConfig.model_validate(boxes[1])).inside(path.pose(S)[:, CONTROLLED])
    assert 0 < np.count_nonzero(inside) < 400
    refused = vary(wide, {"task.avoid": boxes, "certify.least_width": 1e-4})
    smaller = vary(wide, {"task.avoid": [boxes[0], grazing(machine, -1e-3)[1][1]], "certify.least_width": 1e-3})
    ends = ends_of(machine, path, (0, 0))
    with working_precision(64):
        failed, kept = (prove_path(config, machine, path, ends) for config in (refused, smaller))
    assert failed.failure is not None
    assert abs(failed.failure.s - 0.5) < 0.1
    assert "task.avoid[1] is not proven to be avoided" in failed.failure.reason.text
    assert kept.failure is None
    verdicts = {
        name: [claim.what for claim in verify(config, machine, path, ends, state(kept)) if not claim.verified]
        for name, config in (("smaller", smaller), ("refused", refused))
    }
    assert verdicts["smaller"] == []
    # The premises are others, too; the bounds are refused by themselves.
    assert "the motion stays out of all boxes to avoid" in verdicts["refused"]


def test_the_surface_of_a_box_may_be_touched(wide: Config, machine: Machine, vary: Callable) -> None:
    """As a start on it does, or the middle of a path, but no more than rounding beyond it."""
    path, boxes = grazing(machine, 0.0)
    beside = [{"y_m": [float(START[1]) - 0.2, float(START[1])]}]
    config = vary(wide, {"task.avoid": boxes + beside, "certify.least_width": 1e-3})
    ends = ends_of(machine, path, (0, 0))
    with working_precision(64):
        found = prove_path(config, machine, path, ends)
    assert found.failure is None
    assert all(claim.verified for claim in verify(config, machine, path, ends, state(found)))


def test_drives_that_are_off_stay_out_of_boxes(agder_config: Config, bent: Path, vary: Callable) -> None:
    """What is proven within limits is verified again; for a larger box neither is, though the chain is the same."""
    highest = float(bent.pose(S)[:, 1].max())
    kind, (config, strict) = (
        of_actuators(np.ones(5)),
        (vary(agder_config, {"task.avoid": [{"y_m": [highest + far, 2.0]}]}) for far in (2e-3, 3e-5)),
    )
    with working_precision(64):
        kept, broken = (
            close_chain(
                build_problem(bent.machine, bent, 1e-2, kind(EPS_M)),
                build_error_examiner(error_proven_limits(one, bent.machine)),
            )
            for one in (config, strict)
        )
    assert kept.failure is None
    assert broken.failure is not None
    assert "task.avoid[0] is not proven to be avoided" in broken.failure.reason.text
    proven = proven_chain(kept, kind(EPS_M), within_limits=True)
    (segment,) = evaluate_chain(bent.machine, bent, proven)
    for one, verified in ((config, True), (strict, False)):
        found = errors.measure(one, bent.machine, segment, None)
        assert errors.limit_claim("chain", one, bent.machine, found).verified == verified


FORGERIES: dict[str, Callable[[Data], object]] = {
    "more": lambda data: data["bounds"][KEY].update({"task.avoid[0]": 0.5}),
    "inside": lambda data: data["bounds"][KEY].update({"task.avoid[1]": -1e-4}),
    "missing": lambda data: data["bounds"].pop(KEY),
    "null": lambda data: data["bounds"].update({KEY: None}),
    "one missing": lambda data: data["bounds"][KEY].pop("task.avoid[1]"),
    "another": lambda data: data["bounds"][KEY].update({"task.avoid[2]": 0.0}),
    "no number": lambda data: data["bounds"][KEY].update({"task.avoid[0]": "1"}),
}


def test_forged_certificates_are_refused(
    own_task: Config, own_path: Path, vary: Callable, tmp_path: pathlib.Path
) -> None:
    """The genuine one is verified by the command; whatever is changed in it or in the boxes beside it is refused."""
    boxes: list[dict[str, object]] = [{"x_m": [0.5, 1.0]}, {"z_m": [0.91, 0.95], "rx_deg": [-5.0, 5.0]}]
    config = vary(own_task, {"task.avoid": boxes, "route.avoid_margin": 0.0})
    certificate = certify_path(config, own_path.machine, own_path)
    assert certificate.bounds is not None
    ranges = certificate.bounds.ranges[KEY]
    assert ranges.subjects == ("task.avoid[0]", "task.avoid[1]")
    assert ranges.values[:, 0] == pytest.approx([START[0] - 1.0, 0.91 - START[2]], abs=2e-4)
    write_run(tmp_path / "true", config, own_path, certificate)
    genuine = check_run(tmp_path / "true")
    assert genuine.exit_code == 0, genuine.output
    assert "the motion stays out of all boxes to avoid" in genuine.output
    for name, change in FORGERIES.items():
        write_run(tmp_path / name, config, own_path, certificate)
        forge(tmp_path / name, change)
        assert check_run(tmp_path / name).exit_code != 0, name
    # The boxes beside the certificate are what counts.
    for name, others in (("larger", [{"x_m": [0.5, 1.001]}, boxes[1]]), ("none", [])):
        write_run(tmp_path / name, vary(config, {"task.avoid": others}), own_path, certificate)
        assert check_run(tmp_path / name).exit_code == 1
