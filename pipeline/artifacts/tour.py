"""The folder of a tour: locked while it grows, and refused where something else is."""

import contextlib
import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from pipeline.artifacts.files import staged
from pipeline.artifacts.foreign import refuse_links, refuse_no_folder, refuse_other_content
from pipeline.artifacts.layout import LOCK, TOUR_CSV, TOUR_JSON, TOUR_LEGS, TOUR_POSES
from pipeline.artifacts.lock import locked
from pipeline.errors import UsageError
from pipeline.regular_file import read_regular_file

_MOST_BYTES = 2**26
_BEGUN = b"{}\n"


class TourFolder:
    """A folder of a tour, opened by `open_tour_folder` for one process at a time."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def leg(self, name: str) -> Path:
        """Name the run folder of a leg."""
        return self.path / TOUR_LEGS / name

    def write(self, files: Mapping[str, bytes]) -> None:
        """Replace files as a whole, all of them or none."""
        with staged(self.path, dict(files)) as place:
            place()


@contextlib.contextmanager
def open_tour_folder(path: Path) -> Iterator[TourFolder]:
    """Create or open the folder of a tour, and lock it against others until the end.

    Raises
    ------
    UsageError
        When another process is writing there, or the folder has files and is not one of a tour; nothing was changed.
    """
    refuse_no_folder(path)
    refuse_links(path, (TOUR_JSON, TOUR_CSV, TOUR_POSES, LOCK, f"{TOUR_LEGS}/*"))
    if _content(path / TOUR_JSON) is None:
        refuse_other_content(path, "tour")
    path.mkdir(parents=True, exist_ok=True)
    with locked(path, new=False, state=TOUR_JSON):
        folder = TourFolder(path)
        if not (path / TOUR_JSON).exists():
            folder.write({TOUR_JSON: _BEGUN})
        yield folder


def read_tour(folder: Path) -> dict[str, Any]:
    """Read what is known of a tour.

    Raises
    ------
    UsageError
        When the folder is not one of a finished tour.
    """
    if (data := _content(folder / TOUR_JSON)) is None or "legs" not in data:
        raise UsageError(f"{folder} has no finished tour: call gantry-tau tour for it")
    return data


def _content(file: Path) -> dict[str, Any] | None:
    """Read a record, empty where the tour has only begun; None if the file is something else."""
    try:
        value = json.loads(read_regular_file(file, _MOST_BYTES))
    except (OSError, ValueError, RecursionError):
        return None
    return value if isinstance(value, dict) and (not value or "legs" in value) else None
