"""What is kept of an atlas in `atlas.json`: a record per ordered pair of stations."""

from collections.abc import Iterator

from pydantic import BaseModel, ConfigDict, Field

from pipeline.config.choices import RouteObjective
from pipeline.config.task import PoseConfig
from pipeline.errors import UsageError
from pipeline.stage import Stage
from pipeline.status import Status

_PROVEN = (Status.OPTIMAL, Status.INFEASIBLE, "impossible")


class _Record(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", populate_by_name=True, serialize_by_alias=True)


class MotionRecord(_Record):
    """The motion that was made of a route, as far as was asked for.

    Attributes
    ----------
    status : str
        "done", or "failed".
    run : str
        The run folder, relative to that of the atlas.
    backwards : bool
        Whether it is the motion of that run driven backwards.
    to : str
        The last stage with a result.
    kappa_integral, kappa_max, kappa_bound : float or None
        Of the path: in steps, at samples, proven.
    min_link_distance_m : float or None
        Least distance of link axes.
    verdict : str
        Of the certificate.
    duration_s : float or None
        With what is waited before and after.
    reason, advice : str
        Why a stage failed, and what to change.
    fingerprint : str
        Hash of everything the motion depends on.
    """

    status: str
    run: str
    backwards: bool = False
    to: str = ""
    kappa_integral: float | None = None
    kappa_max: float | None = None
    kappa_bound: float | None = None
    min_link_distance_m: float | None = None
    verdict: str = "skipped"
    duration_s: float | None = None
    reason: str = ""
    advice: str = ""
    fingerprint: str = ""


class PairRecord(_Record):
    """The best route between two stations, or why there is none.

    Attributes
    ----------
    origin, target : str
        The stations; `from` and `to` in the file.
    status : str
        "optimal": proven; "not proven optimal": the best one that was found in time; "infeasible" and "impossible":
        there is none (proven by search, and without one); "time limit", "failed": none was found.
    reason, advice : str
        Why there is none, and what to change.
    objective, bound, gap : float or None
        What `objective_kind` adds up, what no route can be below, and how far apart they are, relatively.
    steps, mode_changes : int or None
        Positions of the route, ends included; changes of working mode, counted per arm.
    kappa_max : float or None
        Largest kappa of a position.
    modes : tuple of str
        Working modes in their order.
    from_reverse : bool
        Whether it follows from the opposite pair.
    route : str
        The route as a table, relative to the folder of the atlas; empty without one.
    seconds : float
        How long it took.
    time_limit_s, memory_gb : float
        What the search was allowed.
    fingerprint : str
        Hash of everything the route depends on, but for these.
    motion : MotionRecord or None
        The motion, where one was asked for.
    """

    origin: str = Field(alias="from")
    target: str = Field(alias="to")
    status: str
    reason: str = ""
    advice: str = ""
    objective: float | None = None
    bound: float | None = None
    gap: float | None = None
    steps: int | None = None
    mode_changes: int | None = None
    kappa_max: float | None = None
    modes: tuple[str, ...] = ()
    from_reverse: bool = False
    route: str = ""
    seconds: float = 0.0
    time_limit_s: float
    memory_gb: float
    fingerprint: str
    motion: MotionRecord | None = None

    @property
    def name(self) -> str:
        """The pair as the name of files."""
        return f"{self.origin}--{self.target}"

    @property
    def is_proven(self) -> bool:
        """Whether it is proven which route is the best, or that there is none."""
        return self.status in _PROVEN

    @property
    def is_motion_open(self) -> bool:
        """Whether a motion was tried and is not there."""
        return self.motion is not None and self.motion.status != "done"


class StationRecord(_Record):
    """A station: its name, and its pose as in the configuration."""

    name: str
    pose: PoseConfig


class AtlasRecord(_Record):
    """The atlas as a whole.

    Attributes
    ----------
    name : str
        The name of the configuration.
    config_sha256 : str
        Hash of the configuration, the stations left out.
    to : str
        The last stage that was asked for last: "route", or a later one where motions were.
    versions : dict
        Of what computed it.
    objective_kind : RouteObjective
        What routes minimise.
    reversible : bool
        Whether the best route back is the one there, backwards, so that one of each two pairs was searched.
    stations : tuple of StationRecord
    pairs : tuple of PairRecord
        Those found so far, ordered by station.
    """

    name: str
    config_sha256: str
    to: str = Stage.ROUTE
    versions: dict[str, str]
    objective_kind: RouteObjective
    reversible: bool
    stations: tuple[StationRecord, ...]
    pairs: tuple[PairRecord, ...] = ()

    def problems(self) -> list[PairRecord]:
        """List the pairs of which something that was asked for last is missing without a proof that it has to."""
        motions = self.to != Stage.ROUTE
        return [record for record in self.pairs if not record.is_proven or (motions and record.is_motion_open)]

    @property
    def names(self) -> list[str]:
        """The names of the stations."""
        return [station.name for station in self.stations]

    def wanted(self) -> Iterator[tuple[str, str]]:
        """List the ordered pairs of different stations."""
        return ((origin, target) for origin in self.names for target in self.names if origin != target)

    def pair(self, origin: str, target: str) -> PairRecord:
        """Find the record of a pair.

        Raises
        ------
        UsageError
            When a station is unknown, both are the same, or the pair was not searched yet.
        """
        for name in (origin, target):
            if name not in self.names:
                raise UsageError(f"the atlas has no station {name}; it has {', '.join(self.names)}")
        if origin == target:
            raise UsageError(f"a route from {origin} to itself is none: give two stations")
        for record in self.pairs:
            if (record.origin, record.target) == (origin, target):
                return record
        raise UsageError(
            f"the atlas was interrupted before {origin} to {target}.\n"
            "  What to change: call gantry-tau atlas again, with the same configuration: it goes on where it ended."
        )
