"""The folder of an atlas: locked while it grows, every finished pair on disk at once, old results kept."""

import contextlib
from collections.abc import Iterable, Iterator
from pathlib import Path

from pipeline.artifacts.atlas_record import read_atlas
from pipeline.artifacts.files import json_bytes, staged, write_whole
from pipeline.artifacts.folder import next_numbered
from pipeline.artifacts.foreign import refuse_links, refuse_no_folder, refuse_other_content
from pipeline.artifacts.layout import (
    ATLAS_JSON,
    ATLAS_PICTURE,
    ATLAS_ROUTES,
    ATLAS_RUNS,
    LOCK,
    ROUTE_CSV,
    ROUTE_NPZ,
    SUPERSEDED,
)
from pipeline.artifacts.lock import locked
from pipeline.artifacts.npz import read_npz, readable
from pipeline.artifacts.results.route import route_files, unpack_route
from pipeline.atlas.record import AtlasRecord, PairRecord
from pipeline.errors import UsageError
from pipeline.route.result import Route


class AtlasFolder:
    """A folder of an atlas, opened by `open_atlas_folder` for one process at a time.

    Attributes
    ----------
    path : Path
        The folder.
    record : AtlasRecord or None
        What is in it; None if it is new.
    """

    def __init__(self, path: Path, record: AtlasRecord | None) -> None:
        self.path = path
        self.record = record

    def write(self, record: AtlasRecord) -> None:
        """Replace the record."""
        write_whole(self.path / ATLAS_JSON, json_bytes(record.model_dump(mode="json")))
        self.record = record

    def write_route(self, pair: str, route: Route) -> str:
        """Write the route of a pair; return the name of its table."""
        files = route_files(route)
        names = _route_names(pair)
        with staged(self.path, {names[kind]: content for kind, content in files.items()}) as place:
            place()
        return names[ROUTE_CSV]

    def load_route(self, pair: str) -> Route | None:
        """Load the route of a pair; None if its file is missing or damaged."""
        file = self.path / _route_names(pair)[ROUTE_NPZ]
        try:
            with readable(file):
                return unpack_route(read_npz(file))
        except (UsageError, OSError):
            return None

    def supersede(self, pairs: Iterable[PairRecord]) -> None:
        """Move the routes of pairs away, beside a copy of the record that they belong to."""
        files = [name for pair in pairs for name in _route_names(pair.name).values() if (self.path / name).is_file()]
        if not files:
            return
        attic = next_numbered(self.path / SUPERSEDED)
        write_whole(attic / ATLAS_JSON, (self.path / ATLAS_JSON).read_bytes())
        (attic / ATLAS_ROUTES).mkdir()
        for name in files:
            (self.path / name).replace(attic / name)


@contextlib.contextmanager
def open_atlas_folder(path: Path) -> Iterator[AtlasFolder]:
    """Create or open the folder of an atlas, and lock it against others until the end.

    Raises
    ------
    UsageError
        When another process is writing there, or the folder has files and is not one of an atlas; nothing was changed.
    """
    refuse_no_folder(path)
    refuse_links(path, (ATLAS_JSON, ATLAS_PICTURE, LOCK, f"{ATLAS_ROUTES}/*", f"{ATLAS_RUNS}/*", f"{SUPERSEDED}/*"))
    record = read_atlas(path) if (path / ATLAS_JSON).exists() else None
    if record is None:
        refuse_other_content(path, "atlas")
    path.mkdir(parents=True, exist_ok=True)
    with locked(path, new=False, state=ATLAS_JSON):
        yield AtlasFolder(path, record if record is None else read_atlas(path))


def _route_names(pair: str) -> dict[str, str]:
    """Name the files of a pair's route by those of a run's."""
    return {kind: f"{ATLAS_ROUTES}/{pair}.{kind.rpartition('.')[2]}" for kind in (ROUTE_NPZ, ROUTE_CSV)}
