"""Short paths that break a limit of bodies or joints for a moment, and keep it wherever one looks a few times.

Every case is drawn: a path of one polynomial, and what is in its way or asked for. Beside it is a harmless one, of the
same path and the same pairs, that keeps its limit: what refuses the one and passes the other is not only cautious.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations
from typing import Any

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.config import Config
from pipeline.config.file import parse_config
from pipeline.limits.bodies.pairs import kept_apart, pair_distances
from pipeline.limits.joint_cone import joint_angles_deg
from pipeline.machine import Machine, build_machine
from pipeline.machine.bodies.placement import Frames
from pipeline.machine.samples import PoseSamples
from pipeline.machine.shapes.hulls import config_name
from pipeline.machine.shapes.model import FrameKind, SweptHull
from pipeline.refine import Path
from tests.certify.paths import pose_path

LOOKS = 9
"""Places where one looks, evenly along a path."""
FINE = np.linspace(0.0, 1.0, 801)
REQUIRED_M = 0.0005
_THIN_M = 0.001
_FAR_M = 0.3
_BESIDE_M = 0.25
"""How far from the way things are in harmless cases."""
_LINKS = ("l1", "l2a", "l2b", "l3a", "l3b", "l3c")
_NODES = 6
_LOW, _HIGH = [0.9, 0.25, 0.85, -0.1, -0.1], [1.2, 0.4, 0.95, 0.1, 0.1]
_FARTHEST = [0.12, 0.12, 0.12, 0.15, 0.15]


@dataclass(frozen=True, eq=False)
class Case:
    """A false path, and a harmless one beside it that has the same pairs and joints.

    Attributes
    ----------
    config, harmless : Config
        What is asked for and in the way of both.
    path : Path
        The path of both.
    """

    config: Config
    harmless: Config
    path: Path

    def margins(self, config: Config, s: FloatArray) -> FloatArray:
        """Compute at each s how much of what is asked is left, metres or degrees. Shape (n,)."""
        machine = build_machine(config.machine)
        samples = PoseSamples(machine, self.path.pose(s), self.path.q(s))
        if machine.joint_cones:
            left = [one.half_angle_deg - joint_angles_deg(one, samples) for one in machine.joint_cones]
            return np.min(left, axis=0)
        return (
            pair_distances(kept_apart(config, machine), samples, _FAR_M).min(axis=1) - config.machine.clearance.bodies_m
        )

    @cached_property
    def left(self) -> FloatArray:
        """Margins of the false path at `FINE`."""
        return self.margins(self.config, FINE)

    @property
    def seen(self) -> float:
        """Least margin where one looks."""
        return float(self.left[:: (len(FINE) - 1) // (LOOKS - 1)].min())

    @property
    def broken(self) -> FloatArray:
        """All s where the limit is broken."""
        return FINE[self.left < 0.0]

    @property
    def is_one(self) -> bool:
        """Whether the path is false without being seen to be, and the harmless one keeps its limit by far enough."""
        enough, room = (1e-4, 1e-3) if not build_machine(self.config.machine).joint_cones else (5e-3, 0.2)
        if self.seen < enough or self.left.min() > -enough:
            return False
        return float(self.margins(self.harmless, FINE).min()) >= room


def draw_case(kind: str, seed: int, base: Config) -> Case:
    """Draw cases of a kind until one is false without being seen to be."""
    rng, document = np.random.default_rng(seed), thin_machine(base)
    while True:
        for case in KINDS[kind](rng, document):
            if case.is_one:
                return case


def thin_machine(base: Config) -> dict[str, Any]:
    """Give the machine a needle and a pin as thin as wires, links as lines, and other limits that no path meets."""
    document = base.model_dump(mode="json")
    machine = document["machine"]
    machine["dynamics"] = None
    machine["bodies"] = [
        {"name": "needle", "attached_to": "platform", "capsule": _capsule([0.0, 0.02, 0.0], [0.0, -0.1, 0.0])},
        {"name": "pin", "attached_to": "cart1", "capsule": _capsule([0.0, -0.05, 0.0], [0.0, -0.1, -0.1])},
    ]
    machine["clearance"] = {"link_link_m": 0.0, "bodies_m": REQUIRED_M}
    for rail in machine["rails"]:
        rail["travel_m"] = [-2.0, 4.0]
    for name in ("l2b", "l3b"):
        machine["links"][name]["stroke_m"] = [0.85, 3.0]
    limits = machine["limits"]
    limits["carts"]["force_n"] = limits["telescopes"]["force_n"] = limits["link_force_n"] = None
    document["route"]["kappa_max"] = 1e6
    document["task"]["tilt_max_deg"] = 85.0
    document["certify"] |= {"kappa_excess": 0.03, "least_width": 8e-3}
    return document


def _capsule(first: Any, second: Any, radius_m: float = _THIN_M) -> dict[str, Any]:
    return {"from_m": np.asarray(first).tolist(), "to_m": np.asarray(second).tolist(), "radius_m": radius_m}


def _path(rng: np.random.Generator, machine: Machine, *, there_and_back: bool = False) -> Path:
    """Draw a short path of one polynomial in working mode LLL; one that turns round has its extremes inside."""
    start, way = rng.uniform(_LOW, _HIGH), rng.choice([-1.0, 1.0], 5) * rng.uniform(0.4, 1.0, 5) * _FARTHEST
    s = np.linspace(0.0, 1.0, _NODES)
    if there_and_back:
        turn = (rng.choice([3.0, 4.0]) + rng.uniform(0.4, 0.6)) / (LOOKS - 1)
        shape = 1.0 - ((s - turn) / max(turn, 1.0 - turn)) ** 2
        return pose_path(machine, start + shape[:, None] * way + s[:, None] * 0.02 * way[::-1], 0, _NODES)
    return pose_path(machine, start + s[:, None] * way, 0, _NODES)


@dataclass(frozen=True)
class _Crossing:
    """A point of a thin hull between two places where one looks: where it is, and how it moves.

    Attributes
    ----------
    hull : str
        The hull, by its name in the configuration.
    point : (3,)
        The point in space, or from a cart.
    along, across : (3,)
        Unit vectors along the hull, and across both it and its movement.
    """

    hull: str
    point: FloatArray
    along: FloatArray
    across: FloatArray

    @property
    def ahead(self) -> FloatArray:
        """Unit vector across the hull that it moves along."""
        return np.cross(self.along, self.across)

    @classmethod
    def draw(cls, rng: np.random.Generator, path: Path, hull: SweptHull, cart: int | None) -> "_Crossing":
        s = (rng.integers(1, LOOKS - 2) + rng.uniform(0.4, 0.6)) / (LOOKS - 1)
        at = np.array([s - 1e-4, s, s + 1e-4])
        samples = PoseSamples(path.machine, path.pose(at), path.q(at))
        frames = Frames.of(path.machine, samples.pose, samples.carts_m)
        first, *_, last = frames.points(hull)
        part = rng.uniform(0.3, 0.7)
        places = ((1.0 - part) * first + part * last).T
        if cart is not None:
            places[:, 0] -= samples.carts_m[:, cart]
            places[:, 1:] -= path.machine.rails_m[cart]
        along = (last - first)[:, 1] / np.linalg.norm((last - first)[:, 1])
        across = np.cross(along, places[2] - places[0])
        return cls(config_name(hull), places[1], along, across / np.linalg.norm(across))


def _crossed(rng: np.random.Generator, document: dict[str, Any], cart: int | None = None) -> tuple[Path, _Crossing]:
    """Draw a path, and where a hull goes through that does not move with the cart."""
    machine = build_machine(parse_config(document).machine)
    assert machine.bodies is not None
    path = _path(rng, machine)
    movers = [
        hull
        for hull in machine.bodies.hulls
        if hull.kind == FrameKind.PLATFORM or (hull.kind == FrameKind.LINK and hull.number not in _links_of(cart))
    ]
    return path, _Crossing.draw(rng, path, movers[rng.integers(len(movers))], cart)


def _links_of(cart: int | None) -> tuple[int, ...]:
    return () if cart is None else ((0,), (1, 2), (3, 4, 5))[cart]


def _asking(document: dict[str, Any], kept: frozenset[str], bodies_m: float = REQUIRED_M, **parts: Any) -> Config:
    """Add obstacles to the task or bodies to the machine, and keep one pair apart, by so much."""
    obstacles, more = parts.get("obstacles", []), parts.get("bodies", [])
    bodies = [*document["machine"]["bodies"], *more]
    names = [*(one["name"] for one in (*bodies, *obstacles)), *_LINKS]
    clearance = {
        **document["machine"]["clearance"],
        "bodies_m": bodies_m,
        "ignore": [pair for pair in combinations(names, 2) if kept != frozenset(pair)],
    }
    machine = {**document["machine"], "bodies": bodies, "clearance": clearance}
    return parse_config({**document, "machine": machine, "task": {**document["task"], "obstacles": obstacles}})


def _of(path: Path, config: Config) -> Path:
    return replace(path, machine=build_machine(config.machine))


def bars(rng: np.random.Generator, document: dict[str, Any]) -> Iterator[Case]:
    """A wire across the way, which a needle or link passes through between two places."""
    path, place = _crossed(rng, document)

    def shape(shift: float) -> dict[str, Any]:
        middle, half = place.point + shift * place.across, 0.015 * place.across
        return {"name": "wire", "capsule": _capsule(middle - half, middle + half, 0.0002)}

    yield from _moved(document, path, place, shape)


def scraps(rng: np.random.Generator, document: dict[str, Any]) -> Iterator[Case]:
    """A grain in the way, or a sheet of a tenth of a millimetre, square to it."""
    path, place = _crossed(rng, document)
    if rng.integers(2):
        corners, radius = rng.normal(size=(5, 3)) * 0.0002, 0.0001
    else:
        sides = ((-1, -1), (1, -1), (1, 1), (-1, 1))
        corners, radius = np.array([0.004 * (i * place.along + j * place.across) for i, j in sides]), 0.00005

    def shape(shift: float) -> dict[str, Any]:
        points = place.point + shift * place.across + corners
        return {"name": "scrap", "hull": {"points_m": points.tolist(), "radius_m": radius}}

    yield from _moved(document, path, place, shape)


def _moved(
    document: dict[str, Any], path: Path, place: _Crossing, shape: Callable[[float], dict[str, Any]]
) -> Iterator[Case]:
    """Put an obstacle into the way, and beside it for the harmless case."""
    kept = frozenset((place.hull, shape(0.0)["name"]))
    config, harmless = (_asking(document, kept, obstacles=[shape(shift)]) for shift in (0.0, _BESIDE_M))
    yield Case(config, harmless, _of(path, config))


def cart_bars(rng: np.random.Generator, document: dict[str, Any]) -> Iterator[Case]:
    """A wire on a cart that meets the needle, or a link of another cart, in passing."""
    cart = int(rng.integers(3))
    path, place = _crossed(rng, document, cart)

    def shape(shift: float) -> dict[str, Any]:
        middle, half = place.point + shift * place.across, 0.015 * place.across
        return {
            "name": "wire",
            "attached_to": f"cart{cart + 1}",
            "capsule": _capsule(middle - half, middle + half, 0.0002),
        }

    kept = frozenset((place.hull, "wire"))
    config, harmless = (_asking(document, kept, bodies=[shape(shift)]) for shift in (0.0, _BESIDE_M))
    yield Case(config, harmless, _of(path, config))


def grazed(rng: np.random.Generator, document: dict[str, Any]) -> Iterator[Case]:
    """A box, a bar or a stone beside the way, nearest between two places; a little less is kept there."""
    path, place = _crossed(rng, document)
    out = place.ahead * rng.uniform(-0.04, 0.04) + place.across * rng.choice([-1.0, 1.0]) * rng.uniform(0.01, 0.04)
    centre = place.point + out
    shapes: tuple[dict[str, Any], ...] = (
        {"box": {"centre_m": centre.tolist(), "size_m": rng.uniform(0.005, 0.03, 3).tolist(), "rounding_m": 0.001}},
        {"capsule": _capsule(centre, centre + rng.normal(size=3) * 0.02, 0.004)},
        {"hull": {"points_m": (centre + rng.normal(size=(6, 3)) * 0.005).tolist(), "radius_m": 0.002}},
    )
    obstacle = {"name": "obstacle", **shapes[rng.integers(3)]}
    yield from _nearly_kept(document, path, frozenset((place.hull, "obstacle")), obstacles=[obstacle])


def rods(rng: np.random.Generator, document: dict[str, Any]) -> Iterator[Case]:
    """Bodies of the machine among each other: rods, tubes, needle and pin, nearest where the path turns round."""
    thin = {"radius_m": _THIN_M}
    telescope = {"rod_radius_m": _THIN_M, "tube_radius_m": 1.5 * _THIN_M, "tube_length_m": 0.8}
    links = {name: telescope if name in ("l2b", "l3b") else thin for name in _LINKS}
    clearance = {"link_link_m": None, "bodies_m": REQUIRED_M}
    document = {**document, "machine": {**document["machine"], "link_bodies": links, "clearance": clearance}}
    machine = build_machine(parse_config(document).machine)
    path, bodies = _path(rng, machine, there_and_back=True), machine.bodies
    assert bodies is not None
    samples = PoseSamples(machine, path.pose(FINE), path.q(FINE))
    distances = pair_distances((bodies,), samples, _FAR_M)
    dips = np.flatnonzero(distances[:: (len(FINE) - 1) // (LOOKS - 1)].min(axis=0) - distances.min(axis=0) > 3e-4)
    for number in rng.permutation(dips)[:1].tolist():
        first, second = (config_name(bodies.hulls[one]) for one in bodies.pairs[number])
        yield from _nearly_kept(document, path, frozenset((first, second)))


def _nearly_kept(document: dict[str, Any], path: Path, kept: frozenset[str], **parts: Any) -> Iterator[Case]:
    """Ask for a distance between the least of all and the least where one looks; for less of the harmless."""
    config = _asking(document, kept, **parts)
    probe = Case(config, config, path)
    least, seen = float(probe.left.min()) + REQUIRED_M, probe.seen + REQUIRED_M
    if least > 2.5e-3:
        asked = 0.5 * (least + seen)
        config, harmless = (_asking(document, kept, one, **parts) for one in (asked, least - 2e-3))
        yield Case(config, harmless, _of(path, config))


def cones(rng: np.random.Generator, document: dict[str, Any]) -> Iterator[Case]:
    """A joint that leaves its cone where the path turns round."""
    link, end = _LINKS[rng.integers(6)], ("platform_cone", "cart_cone")[rng.integers(2)]
    axis = rng.normal(size=3)

    def config(half_angle_deg: float) -> Config:
        links = document["machine"]["links"]
        one = {"axis": (axis / np.linalg.norm(axis)).tolist(), "half_angle_deg": half_angle_deg}
        machine = {**document["machine"], "links": {**links, link: {**links[link], end: one}}}
        return parse_config({**document, "machine": {**machine, "bodies": (), "clearance": {"link_link_m": 0.0}}})

    path = _path(rng, build_machine(config(170.0).machine), there_and_back=True)
    probe = Case(config(170.0), config(170.0), path)
    largest, seen = 170.0 - float(probe.left.min()), 170.0 - probe.seen
    if 20.0 < largest < 160.0:
        asked = 0.5 * (largest + seen)
        yield Case(config(asked), config(largest + 0.5), _of(path, config(asked)))


KINDS: dict[str, Callable[[np.random.Generator, dict[str, Any]], Iterator[Case]]] = {
    "a wire is passed through": bars,
    "a scrap is passed through": scraps,
    "a wire on a cart is passed through": cart_bars,
    "an obstacle is grazed": grazed,
    "bodies graze each other": rods,
    "a joint leaves its cone": cones,
}
