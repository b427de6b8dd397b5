"""What is said of bodies in the way: which link, from which side to which, and how far from an end."""

import pytest

from pipeline.config import Config
from pipeline.config.file import load_config
from pipeline.limits import relaxations
from pipeline.limits.bodies.obstruction import obstruction
from pipeline.machine import Machine, build_machine
from pipeline.machine.bodies.distances import body_distances
from pipeline.machine.samples import PoseSamples
from pipeline.route import build_regions, plan_route
from pipeline.route.diagnosis.relaxed_table import along
from pipeline.route.diagnosis.result import Verdict
from pipeline.route.diagnosis.search import explain_infeasibility
from tests.conftest import CONFIGS, WITHOUT_FORCE_LIMITS

AXIS = {"capsule": {"from_m": [0.0, 0.03, 0.0], "to_m": [0.0, 0.45, 0.0], "radius_m": 0.03}}
BLOCK = {"box": {"centre_m": [0.0, 0.24, 0.0], "size_m": [0.04, 0.42, 0.04]}}
IGNORED = [["spindle", "l3a"], ["spindle", "l3b"]]


@pytest.fixture(scope="module")
def bare(vary) -> Config:
    """Take the task on a very coarse grid; a route exists."""
    tilts = {"route.grid.rx_step_deg": 10, "route.grid.rz_step_deg": 10, "task.tilt_max_deg": 10}
    return vary(load_config(CONFIGS / "tiny.yaml"), WITHOUT_FORCE_LIMITS | tilts)


@pytest.fixture(scope="module")
def motion(bare: Config) -> PoseSamples:
    """Follow that route."""
    machine = build_machine(bare.machine)
    return along(machine, plan_route(bare, machine, build_regions(bare, machine)))


def with_spindle(bare: Config, vary, shape: dict[str, object], at: str = "platform") -> tuple[Config, Machine]:
    """Put a spindle on the axis through joints 3a and 3b."""
    ignored = {"machine.clearance.ignore": IGNORED}
    config = vary(bare, {"machine.bodies": [{"name": "spindle", "attached_to": at, **shape}]} | ignored)
    return config, build_machine(config.machine)


def test_a_spindle_in_the_way_has_to_be_passed_round_its_end(bare: Config, vary) -> None:
    """Without it a route exists; on that, links 2a and 2b sweep from one side of it to the other."""
    config, machine = with_spindle(bare, vary, AXIS)
    limits = [limit for limit in relaxations(config, machine) if limit.key == "machine.bodies[0]"]
    (finding,) = explain_infeasibility(config, machine, build_regions(config, machine), limits=limits).opening
    assert finding.verdict is Verdict.OPENS
    for words in (
        "without machine.bodies[0]: a route exists, sum of kappa 219.8; on it, link 2a passes right through spindle, "
        "from its -z to its +z side (axes of the platform), 0.13 m from its end at (0, 0.03, 0)",
        "link 2b passes right through spindle, from its -z to its +z side (axes of the platform), ",
        "m from its end at (0, 0.45, 0)",
        "spindle has to be passed round an end: make it shorter there, or move it",
    ):
        assert words in finding.sentence


def test_what_has_no_axis_overlaps(bare: Config, vary, motion: PoseSamples) -> None:
    """Of other shapes the pairs are named with their distances, the worst first."""
    _, machine = with_spindle(bare, vary, BLOCK)
    assert machine.bodies is not None
    words = obstruction(machine.bodies, {"spindle"}, motion)
    assert words == "spindle and link 2a overlapping; spindle and link 2b overlapping"


def test_what_is_not_in_the_way_is_not_mentioned(bare: Config, vary, motion: PoseSamples) -> None:
    """A spindle that ends where links do not sweep, and bodies of other names."""
    short = {"capsule": {**AXIS["capsule"], "to_m": [0.0, 0.05, 0.0], "radius_m": 0.01}}
    _, machine = with_spindle(bare, vary, short)
    assert machine.bodies is not None
    assert (body_distances(machine.bodies, motion).min(axis=0) > 0.005).all()
    assert obstruction(machine.bodies, {"spindle"}, motion) == ""
    _, machine = with_spindle(bare, vary, AXIS)
    assert machine.bodies is not None
    assert obstruction(machine.bodies, {"another"}, motion) == ""


def test_an_obstacle_in_the_way_is_named_with_what_meets_it(bare: Config, vary, motion: PoseSamples) -> None:
    """A thin bar that the motion passes, in the axes of the rails."""
    middle = motion.pose[len(motion) // 2, :3]
    from_m, to_m = ((middle + [0.0, 0.05, z]).tolist() for z in (-0.1, 0.1))
    bar = {"name": "bar", "capsule": {"from_m": from_m, "to_m": to_m, "radius_m": 0.01}}
    config = vary(bare, {"task.obstacles": [bar, {**bar, "name": "another"}]})
    found = {limit.key: limit for limit in relaxations(config, build_machine(config.machine))}
    words = found["task.obstacles[0]"].obstruction(motion)
    assert "link 3c passes right through bar, from its -y to its +y side (axes of the rails)" in words
    assert "another" not in words
    config = vary(bare, {"machine.bodies": [{**bar, "attached_to": "frame"}]})
    found |= {limit.key: limit for limit in relaxations(config, build_machine(config.machine))}
    assert found["machine.bodies[0]"].obstruction(motion) == words
    assert "bar and another have to be passed round an end" in found["task.obstacles"].obstruction(motion)
