"""The content of a report as plain data: built by `build`, rendered as a page by `page`."""

from dataclasses import dataclass, field
from typing import Literal

from pipeline.arrays import FloatArray, IntArray
from pipeline.machine.bodies.meshes import BodyMesh

Mood = Literal["good", "bad", "open"]
"""What a statement means for the reader: all is well, something failed, or nothing is decided."""
MotionName = Literal["refined", "coarse"]


@dataclass(frozen=True)
class Verdict:
    """A key statement: its topic, the answer in a word or number, and the details."""

    topic: str
    answer: str
    detail: str
    mood: Mood


@dataclass(frozen=True)
class StageRow:
    """How a stage ended: its status, its figures or the reason in words, what to change, and what prevents a result.

    `remarks` are what is known of a task without a result, `findings` the single changes that were tried, and what came
    of them.
    """

    name: str
    status: str
    mood: Mood
    words: str
    advice: str = ""
    remarks: tuple[str, ...] = ()
    findings: tuple[str, ...] = ()


@dataclass(frozen=True)
class UsedLimit:
    """The largest fraction of a limit that the motion uses, and what uses it."""

    kind: str
    subject: str
    part: float


@dataclass(frozen=True)
class Table:
    """Cells of text under headings; the columns `words` are text, all others numbers; `note` says how they arose."""

    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    words: tuple[int, ...]
    note: str = ""


@dataclass(frozen=True)
class Picture:
    """A PNG in base64, and what it shows in words and numbers, for those who cannot see it."""

    png: str
    alt: str


@dataclass(frozen=True)
class RoutePart:
    """The steps of the route; their picture where there is no motion to show instead."""

    table: Table
    picture: Picture | None = None


@dataclass(frozen=True, eq=False)
class KappaMaps:
    """kappa over the YZ plane at instants of a motion, for the tilt and working mode the machine has there.

    Attributes
    ----------
    t_s, modes : (k,), (k,)
        The instants, and the working modes there; every working mode of the motion is among them.
    y_m, z_m : (ny,), (nz,)
        Grid values.
    kappa : (k, nz, ny)
        NaN out of reach.
    loops : k arrays (m, 2)
        y and z along the curves det H = 0, a row of NaN between two curves.
    titles : k texts
        Working mode and tilt.
    colour_limit : float
        The kappa at which the colour scale ends.
    """

    t_s: FloatArray
    modes: IntArray
    y_m: FloatArray
    z_m: FloatArray
    kappa: FloatArray
    loops: tuple[FloatArray, ...]
    titles: tuple[str, ...]
    colour_limit: float


@dataclass(frozen=True, eq=False)
class NearestPairs:
    """The nearest pair at n instants: of bodies among each other, or of these and what is fixed in space.

    Attributes
    ----------
    of : str
        "bodies" or "obstacles".
    pair, distance_m : (n,), (n,)
        The pair, of `Scene.pairs`, and its distance.
    """

    of: str
    pair: IntArray
    distance_m: FloatArray


@dataclass(frozen=True, eq=False)
class Motion:
    """The machine at n instants of a motion, with the places of its joints.

    Attributes
    ----------
    name : str
        The path it is along.
    t_s, kappa : (n,)
        Times, condition number of H.
    pose, q_m, qd_mps : (n, 6), (n, 5), (n, 5)
        x, y, z, rx, ry, rz; actuator positions and velocities.
    modes : (n,)
        Working modes, 0 (LLL) to 7 (RRR).
    feet_m, cart_joints_m, platform_joints_m : (n, 3, 3), (n, 6, 3), (n, 6, 3)
        Carts on their rails, both ends of every link.
    maps : KappaMaps
        kappa around the machine.
    nearest : tuple of NearestPairs
        The nearest pairs of bodies, and of bodies and obstacles, where there are any.
    """

    name: MotionName
    t_s: FloatArray
    kappa: FloatArray
    pose: FloatArray
    q_m: FloatArray
    qd_mps: FloatArray
    modes: IntArray
    feet_m: FloatArray
    cart_joints_m: FloatArray
    platform_joints_m: FloatArray
    maps: KappaMaps
    nearest: tuple[NearestPairs, ...] = ()

    def nearest_at(self, instant: int) -> tuple[int, float]:
        """Return the nearest of all pairs at an instant, and its distance in metres; there have to be pairs."""
        distance, pair = min((group.distance_m[instant], group.pair[instant]) for group in self.nearest)
        return int(pair), float(distance)


@dataclass(frozen=True, eq=False)
class Scene:
    """What does not move, and the limits that all motions have.

    Attributes
    ----------
    rails_m : (3, 2, 3)
        Both ends of each rail.
    platform_bars : (m, 2)
        Bars between the TCP (0) and the platform's joints (1 to 6).
    q_limits_m, qd_limits_mps : (5, 2), (5,)
        Least and largest actuator position; largest speed.
    moment_unit : str
        What the moments in kappa are measured in.
    meshes : tuple of BodyMesh
        The bodies; empty without any.
    pairs : pairs of indices
        The bodies of each pair that is kept apart; -1 for an axis, which has no surface.
    pair_names : texts
        Their names.
    clearance_m, alarm_m : float
        Least distance of pairs that is required; the nearest pair is red below the second.
    """

    rails_m: FloatArray
    platform_bars: IntArray
    q_limits_m: FloatArray
    qd_limits_mps: FloatArray
    moment_unit: str
    meshes: tuple[BodyMesh, ...] = ()
    pairs: tuple[tuple[int, int], ...] = ()
    pair_names: tuple[str, ...] = ()
    clearance_m: float = 0.0
    alarm_m: float = 0.0


@dataclass(frozen=True, eq=False)
class Proof:
    """The certificate's bound of kappa over every box, and kappa as sampled, over the length along the path.

    Attributes
    ----------
    edges : (n + 1,)
        Where boxes begin and end, in steps of the route's metric.
    bound : (n,)
        Upper bounds; infinite where nothing is proven.
    length, kappa : (m,), (m,)
        The samples.
    least_excess : float
        Least relative difference of a bound above a sample in its box.
    """

    edges: FloatArray
    bound: FloatArray
    length: FloatArray
    kappa: FloatArray
    least_excess: float


@dataclass(frozen=True, eq=False)
class Report:
    """Everything on the page; empty or None for what a run does not have.

    Attributes
    ----------
    name, task : str
        The run, and its working modes at start and goal.
    headline : Verdict
        The outcome, in one line.
    verdicts, stages, usage
        The summary.
    quality, rows, drives, comparison, workspace, bounds, distances : Table or None
        Reversals and least times of the actuators; what a controller makes of the rows; what the drives feel; coarse
        against refined; usable workspace; what the certificate proves, also for the nearest pairs of axes and bodies.
    workspace_picture : Picture or None
        The workspace in 3-D.
    route : RoutePart or None
        The steps of the route.
    reach : Picture or None
        What can be reached from start and goal where there is no route.
    scene, motions
        What is animated; `motion_note` explains how the coarse motion was made, or why a motion is missing.
    proof : Proof or None
        kappa and its bound.
    pose_error : Picture or None
        The proven error of the tool.
    pairs : Picture or None
        Distances of bodies along the path.
    config_yaml : str
        The whole configuration.
    provenance : pairs of text
        Versions and hashes.
    """

    name: str
    task: str
    headline: Verdict
    verdicts: tuple[Verdict, ...]
    stages: tuple[StageRow, ...]
    config_yaml: str
    provenance: tuple[tuple[str, str], ...]
    scene: Scene
    usage: tuple[UsedLimit, ...] = ()
    quality: Table | None = None
    rows: Table | None = None
    drives: Table | None = None
    comparison: Table | None = None
    workspace: Table | None = None
    workspace_picture: Picture | None = None
    route: RoutePart | None = None
    reach: Picture | None = None
    bounds: Table | None = None
    distances: Table | None = None
    proof: Proof | None = None
    pose_error: Picture | None = None
    pairs: Picture | None = None
    motions: tuple[Motion, ...] = field(default=())
    motion_note: str = ""
