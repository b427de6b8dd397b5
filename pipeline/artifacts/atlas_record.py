"""The record of an atlas, read by itself: queries load nothing else."""

import errno
from pathlib import Path

from pydantic import ValidationError

from pipeline.artifacts.layout import ATLAS_JSON
from pipeline.atlas.record import AtlasRecord
from pipeline.errors import UsageError
from pipeline.regular_file import read_regular_file

_MOST_BYTES = 2**28
"""Size of the largest atlas that is read: a hundred stations make about a twentieth of it."""


def read_atlas(path: Path) -> AtlasRecord:
    """Read the atlas in a folder.

    Raises
    ------
    UsageError
        When there is none, or it is damaged.
    """
    file = path / ATLAS_JSON
    try:
        return AtlasRecord.model_validate_json(read_regular_file(file, _MOST_BYTES))
    except (FileNotFoundError, NotADirectoryError):
        raise UsageError(
            f"{path} has no {ATLAS_JSON}.\n"
            "  What to change: give the folder that gantry-tau atlas has written to, such as results/agder-atlas."
        ) from None
    except ValidationError as error:
        fault = error.errors(include_url=False, include_input=False)[0]
        place = ".".join(str(part) for part in fault["loc"])
        raise _damaged(file, f"{place}: {fault['msg']}" if place else fault["msg"]) from None
    except OSError as error:
        if error.errno not in (errno.EINVAL, errno.EISDIR, errno.EFBIG):
            raise
        raise _damaged(file, f"it {error.strerror}") from None


def _damaged(file: Path, why: str) -> UsageError:
    return UsageError(
        f"{file} is damaged, or was not written by this program: {why}.\n"
        "  What to change: move it away and call gantry-tau atlas again, or give another folder."
    )
