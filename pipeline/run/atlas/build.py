"""Building an atlas: what of it is up to date, what is missing, and in which order it is found."""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np

from pipeline.artifacts.atlas import AtlasFolder, open_atlas_folder
from pipeline.atlas.graph import AtlasGraph, build_graph
from pipeline.atlas.plan import AtlasEntry, Pair, plan_pairs
from pipeline.atlas.record import AtlasRecord, PairRecord, StationRecord
from pipeline.atlas.reversal import is_path_reversible, is_reversible
from pipeline.atlas.stations import atlas_stations, pair_config, require_stations
from pipeline.config import Config
from pipeline.config.file import config_sha256
from pipeline.machine.geometry import build_machine
from pipeline.progress import QUIET, Monitor
from pipeline.route import grid_regions
from pipeline.route.planner import with_guide
from pipeline.route.regions.size import require_grid_fits
from pipeline.route.result import Route
from pipeline.run.atlas.motions import MotionMaker, motion_fingerprint
from pipeline.run.config_parts import route_part
from pipeline.run.makers.grid_cache import cached_grid
from pipeline.run.results import Results
from pipeline.run.stage_specs import SPECS, Specs, code_roots
from pipeline.run.up_to_date.source_code import code_sha256
from pipeline.stage import Stage
from pipeline.status import Status
from pipeline.summary.versions import package_version, versions

_LIMITS = ("time_limit_s", "memory_gb")
"""Keys of stage one that decide whether a search ends, but not with what."""


@dataclass(frozen=True)
class AtlasOptions:
    """What an atlas has.

    Attributes
    ----------
    last : Stage
        The stage to stop after: the route, or a later one.
    force : bool
        Everything is computed again.
    specs : tuple of StageSpec
        The stages of the runs.
    """

    last: Stage = Stage.ROUTE
    force: bool = False
    specs: Specs = SPECS


def make_atlas(
    config: Config, out: Path | str, options: AtlasOptions = AtlasOptions(), monitor: Monitor = QUIET
) -> AtlasRecord:
    """Find the best routes between all pairs of stations, and motions where they are asked for, into the folder `out`.

    Every finished pair is on disk; what is there and up to date is not computed again. Pairs whose search ended without
    a proof are searched again when `route.time_limit_s` or `route.memory_gb` has changed.

    Raises
    ------
    ConfigError
        When the machine cannot be at a station, or the grid takes up more memory than allowed.
    UsageError
        When another process is writing to the folder, or it is not one of an atlas.
    NoSolutionError
        When the regions and moves that all pairs share take up more memory than allowed.
    """
    machine = build_machine(config.machine)
    require_grid_fits(config)
    stations = atlas_stations(config)
    require_stations(config, machine, stations)
    with open_atlas_folder(Path(out)) as folder:
        build = _Build(config, folder, options, monitor)
        kept = {} if options.force else build.kept()
        folder.supersede(pair for pair in (folder.record.pairs if folder.record else ()) if pair not in kept.values())
        folder.write(
            AtlasRecord(
                name=config.name,
                config_sha256=config_sha256(config),
                to=options.last,
                versions=versions(),
                objective_kind=config.route.objective,
                reversible=is_reversible(config, machine),
                stations=tuple(StationRecord(name=station.name, pose=station.pose) for station in stations),
                pairs=tuple(build.with_motion(pair, record) for pair, record in kept.items()),
            )
        )
        build.find_routes(kept)
        if options.last is not Stage.ROUTE:
            build.make_motions()
        assert folder.record is not None
        return folder.record


class _Build:
    """An atlas that grows; what takes long is computed when it is first needed."""

    def __init__(self, config: Config, folder: AtlasFolder, options: AtlasOptions, monitor: Monitor) -> None:
        self._config = config
        self._machine = build_machine(config.machine)
        self._stations = atlas_stations(config)
        self._folder = folder
        self._options = options
        self._monitor = monitor
        self._known_graph: AtlasGraph | None = None
        self._code = code_sha256(
            ("pipeline.atlas.plan", *code_roots(SPECS, Stage.REGIONS), *code_roots(SPECS, Stage.ROUTE))
        )

    @property
    def _pairs(self) -> list[Pair]:
        """All pairs, opposite ones side by side."""
        count = range(len(self._stations))
        return [pair for i in count for j in count if i < j for pair in ((i, j), (j, i))]

    @property
    def _graph(self) -> AtlasGraph:
        if self._known_graph is None:
            config, machine, monitor = self._config, self._machine, self._monitor
            results = Results(config, machine, self._folder.path, recompute=self._options.force)
            grid = cached_grid(results, monitor, lambda: grid_regions(config, machine, monitor))
            self._known_graph = build_graph(config, machine, self._stations, grid, monitor)
        return self._known_graph

    def _name(self, pair: Pair) -> str:
        return "--".join(self._stations[k].name for k in pair)

    def _pair_config(self, pair: Pair) -> Config:
        return pair_config(self._config, *(self._stations[k] for k in pair))

    def kept(self) -> dict[Pair, PairRecord]:
        """Find the records that are up to date, or as good as what would be found now."""
        if self._folder.record is None:
            return {}
        found = {record.name: record for record in self._folder.record.pairs}
        return {
            pair: found[name]
            for pair in sorted(self._pairs)
            if (name := self._name(pair)) in found and self._holds(pair, found[name])
        }

    def _holds(self, pair: Pair, record: PairRecord) -> bool:
        if record.fingerprint != self._fingerprint(pair):
            return False
        same_limits = all(getattr(record, key) == getattr(self._config.route, key) for key in _LIMITS)
        if not record.is_proven and not same_limits:
            return False
        return not record.route or self._folder.load_route(record.name) is not None

    def _fingerprint(self, pair: Pair) -> str:
        part = route_part(self._pair_config(pair))
        options = {key: value for key, value in part["route"].items() if key not in _LIMITS}
        return config_sha256({**part, "route": options, "version": package_version(), "code": self._code})

    def with_motion(self, pair: Pair, record: PairRecord) -> PairRecord:
        """Keep the motion of a pair only if it is up to date."""
        motion = record.motion
        if motion is None:
            return record
        config = self._pair_config(pair[::-1] if motion.backwards else pair)
        holds = motion.fingerprint == motion_fingerprint(self._options.specs, config, motion.to)
        return record if holds else record.model_copy(update={"motion": None})

    def find_routes(self, kept: dict[Pair, PairRecord]) -> None:
        """Find the routes that are missing."""
        missing = [pair for pair in self._pairs if pair not in kept]
        if not missing:
            return
        entries = {pair: self._entry(pair, record) for pair, record in kept.items()}
        guided = self._options.last is not Stage.ROUTE
        for entry in plan_pairs(self._graph, missing, entries, self._monitor, guided=guided):
            self._add(self._record(entry))

    def _entry(self, pair: Pair, record: PairRecord) -> AtlasEntry:
        route = self._folder.load_route(record.name) if record.route else None
        return AtlasEntry(pair, record.status, route, record.reason, record.advice, record.from_reverse, record.seconds)

    def _record(self, entry: AtlasEntry) -> PairRecord:
        """Write a route, and give its record."""
        origin, target = (self._stations[k].name for k in entry.pair)
        facts: dict[str, object] = {}
        if (route := entry.route) is not None:
            facts = {
                "objective": route.objective,
                "bound": route.search.bound,
                "gap": route.search.gap,
                "steps": len(route),
                "mode_changes": route.mode_changes,
                "kappa_max": route.kappa_max,
                "modes": tuple(mode for mode, _ in groupby(route.mode_names)),
                "route": self._folder.write_route(self._name(entry.pair), route),
            }
        return PairRecord(
            origin=origin,
            target=target,
            status=entry.status,
            reason=entry.reason,
            advice=entry.advice,
            from_reverse=entry.from_reverse,
            seconds=entry.seconds,
            time_limit_s=self._config.route.time_limit_s,
            memory_gb=self._config.route.memory_gb,
            fingerprint=self._fingerprint(entry.pair),
            **facts,
        )

    def _add(self, record: PairRecord) -> None:
        """Put a record in its place, on disk."""
        before = self._folder.record
        assert before is not None
        pairs = {(one.origin, one.target): one for one in (*before.pairs, record)}
        ordered = tuple(pairs[names] for names in before.wanted() if names in pairs)
        self._folder.write(before.model_copy(update={"pairs": ordered}))

    def make_motions(self) -> None:
        """Make the motions of proven routes, up to the stage that is asked for, one for both ways if it may be."""
        assert self._folder.record is not None
        records = {(record.origin, record.target): record for record in self._folder.record.pairs}
        options = self._options
        maker = MotionMaker(self._folder.path, options.last, options.force, options.specs, self._monitor)
        numbers = {station.name: k for k, station in enumerate(self._stations)}
        reversible = is_path_reversible(self._config, self._machine)
        for (origin, target), record in records.items():
            backwards = record.from_reverse and reversible
            there = records[target, origin] if backwards else record
            if there.status != Status.OPTIMAL:
                continue
            pair = numbers[there.origin], numbers[there.target]
            made = maker.motions(there.name, self._pair_config(pair), self._given(pair))
            self._add(record.model_copy(update={"motion": made.backwards if backwards else made.there}))

    def _given(self, pair: Pair) -> dict[Stage, Callable[[], Any]]:
        """Give regions and route of a pair to its run, if it needs them."""
        return {Stage.REGIONS: lambda: self._graph.regions(pair), Stage.ROUTE: lambda: self._guided(pair)}

    def _guided(self, pair: Pair) -> Route:
        """Load a route, with what guides stage two, which is found now if the route was not to be refined before."""
        route = self._folder.load_route(self._name(pair))
        assert route is not None, "records are kept with their routes only"
        if np.isfinite(route.search.least_kappa_max):
            return route
        return with_guide(self._graph.problem(pair, self._monitor), route)
