"""Fixtures shared by all tests, and how hypothesis searches."""

import os
import signal
import threading
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import reduce
from pathlib import Path

# Before numpy is there: tests run in two processes, and their matrices are small; threads would wait for each other.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, settings

from pipeline.arrays import FloatArray, IntArray
from pipeline.config import Config
from pipeline.config.file import load_config, parse_config
from pipeline.machine import Machine, build_machine, condition_number, inverse_kinematics, statics_matrix
from pipeline.machine.geometry import TRIANGLE

WITHOUT_FORCE_LIMITS = {
    "machine.limits.carts.force_n": None,
    "machine.limits.telescopes.force_n": None,
    "machine.limits.link_force_n": None,
}
"""Changes for `vary`, for comparing with values that were computed without looking at forces."""
CONFIGS = Path(__file__).parents[1] / "configs"

# Examples are fixed on a build server: a failure there must come from the change, never from luck.
settings.register_profile("local", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.register_profile("ci", settings.get_profile("local"), derandomize=True, print_blob=True)
settings.load_profile("ci" if os.environ.get("CI") else "local")


@dataclass(frozen=True, eq=False)
class Sample:
    """Reachable random poses of a machine: controlled (n, 5), modes (n,), poses (n, 6), actuators (n, 5)."""

    controlled: FloatArray
    modes: IntArray
    pose: FloatArray
    q_m: FloatArray
    kappa: FloatArray


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Begin with the files of most slow tests, so that none of them is left for one process alone at the end."""
    slow = Counter(item.path for item in items if item.get_closest_marker("slow"))
    items.sort(key=lambda item: -slow[item.path])


@pytest.fixture(scope="session", autouse=True)
def _interruptible() -> Iterator[None]:
    """Let Ctrl-C be what it is, even where the tests run in the background of a script, which ignores it."""
    ignored = signal.getsignal(signal.SIGINT) is signal.SIG_IGN
    if not ignored or threading.current_thread() is not threading.main_thread():
        yield
        return
    signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, signal.SIG_IGN)


@pytest.fixture(scope="session")
def agder_config() -> Config:
    """Load the reference machine and task."""
    return load_config(CONFIGS / "agder.yaml")


@pytest.fixture(scope="session")
def quick_config() -> Config:
    """Load the reference machine on a coarse grid."""
    return load_config(CONFIGS / "quick.yaml")


@pytest.fixture(scope="session")
def bodies_config(quick_config: Config) -> Config:
    """Load the reference machine with bodies, on a coarse grid."""
    return load_config(CONFIGS / "agder-bodies.yaml").model_copy(update={"route": quick_config.route})


@pytest.fixture(scope="session")
def bodies_machine(bodies_config: Config) -> Machine:
    """Build the reference machine with bodies."""
    return build_machine(bodies_config.machine)


@pytest.fixture(scope="session")
def ends_config(bodies_config: Config, vary: Callable[[Config, dict[str, object]], Config]) -> Config:
    """Give that machine bodies at the ends of four links: a sphere and capsules, two of them on one telescope."""
    ends = [("stud", "l2b_platform", -0.06, 0.0, 0.025), ("motor", "l2b_cart", 0.3, 0.15, 0.03)]
    ends += [("ball", "l1_cart", 0.0, 0.0, 0.02), ("collar", "l3a_platform", -0.2, -0.12, 0.018)]
    added = [
        {
            "name": name,
            "attached_to": where,
            "capsule": {"from_m": [0.0, 0.0, first], "to_m": [0.0, 0.0, last], "radius_m": radius},
        }
        for name, where, first, last, radius in ends
    ]
    return vary(bodies_config, {"machine.bodies": [*bodies_config.model_dump()["machine"]["bodies"], *added]})


@pytest.fixture(scope="session")
def ends_machine(ends_config: Config) -> Machine:
    """Build the machine with bodies at the ends of links."""
    return build_machine(ends_config.machine)


@pytest.fixture(scope="session")
def machine(agder_config: Config) -> Machine:
    """Build the reference machine."""
    return build_machine(agder_config.machine)


@pytest.fixture(scope="session")
def vary() -> Callable[[Config, dict[str, object]], Config]:
    """Give a function that sets keys, written with dots, in a copy of a configuration."""

    def change(config: Config, values: dict[str, object]) -> Config:
        data = config.model_dump()
        for path, value in values.items():
            *sections, key = path.split(".")
            reduce(lambda part, name: part[int(name) if name.isdigit() else name], sections, data)[key] = value
        return parse_config(data)

    return change


@pytest.fixture(scope="session")
def draw_controlled() -> Callable[[int, int], tuple[FloatArray, IntArray]]:
    """Draw controlled poses (n, 5) around the workspace, and working modes (n,)."""

    def draw(seed: int, count: int) -> tuple[FloatArray, IntArray]:
        rng = np.random.default_rng(seed)
        low, high = [0.0, -0.4, 0.1, -0.5, -0.5], [2.0, 1.2, 1.5, 0.5, 0.5]
        return rng.uniform(low, high, (count, 5)), rng.integers(0, 8, count)

    return draw


@pytest.fixture(scope="session")
def draw_poses(
    draw_controlled: Callable[[int, int], tuple[FloatArray, IntArray]],
) -> Callable[..., Sample]:
    """Draw those of random poses that a machine reaches with kappa below a cap."""

    def draw(machine: Machine, seed: int, count: int = 150, kappa_max: float = 100.0) -> Sample:
        controlled, modes = draw_controlled(seed, count)
        solution = inverse_kinematics(machine, controlled, modes)
        rows = np.flatnonzero(solution.reachable)
        kappa = condition_number(statics_matrix(machine, solution.pose[rows], solution.q_m[rows, :3]))
        rows, kappa = rows[kappa < kappa_max], kappa[kappa < kappa_max]
        # A random machine may have no such pose among the drawn ones: then there is nothing to test.
        assume(len(rows) > 0)
        return Sample(controlled[rows], modes[rows], solution.pose[rows], solution.q_m[rows], kappa)

    return draw


@pytest.fixture(scope="session")
def draw_machine(machine: Machine) -> Callable[[int, str], Machine]:
    """Draw machines like the reference machine.

    "on axis" keeps a_3a on the platform's y axis and the triangle right-angled; "off axis" moves a_3a away from
    it; "general" gives links 3a and 3c different joints on the cart and the triangle any angle, too. Moments are
    divided by any length.
    """

    def draw(seed: int, kind: str) -> Machine:
        rng = np.random.default_rng(seed)
        points = machine.platform_points_m + rng.uniform(-0.03, 0.03, (6, 3))
        offsets = machine.cart_offsets_m + rng.uniform(-0.02, 0.02, (6, 3))
        lengths = machine.lengths_m * rng.uniform(0.97, 1.03, 6)
        if kind == "on axis":
            points[3, [0, 2]] = 0.0
        if kind != "general":
            offsets[TRIANGLE] = offsets[3]
            lengths[TRIANGLE] = np.hypot(lengths[3], np.linalg.norm(points[TRIANGLE] - points[3]))
        return replace(
            machine,
            rails_m=machine.rails_m + rng.uniform(-0.05, 0.05, (3, 2)),
            platform_points_m=points,
            cart_offsets_m=offsets,
            lengths_m=lengths,
            triangle_sign=rng.choice([-1.0, 1.0]),
            characteristic_length_m=rng.uniform(0.3, 3.0),
        )

    return draw
