"""The failure of a stage as files, under names that no result has."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from pipeline.artifacts.files import json_bytes
from pipeline.artifacts.layout import failure_names, failure_picture
from pipeline.artifacts.npz import npz_bytes
from pipeline.artifacts.results.figures import picture_bytes
from pipeline.stage import Stage

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def failure_files(
    stage: Stage, facts: Mapping[str, Any], diagnosis: Mapping[str, object], picture: "Figure | None" = None
) -> dict[str, bytes]:
    """Write why a stage failed; arrays of the diagnosis and a picture go to files of their own."""
    text_name, arrays_name = failure_names(stage)
    arrays = {key: value for key, value in diagnosis.items() if isinstance(value, np.ndarray) and value.dtype != object}
    rest = {key: value for key, value in diagnosis.items() if key not in arrays}
    files = {text_name: json_bytes({**facts, "diagnosis": rest, "arrays": sorted(arrays)})}
    if arrays:
        files[arrays_name] = npz_bytes(arrays)
    if picture is not None:
        files[failure_picture(stage)] = picture_bytes(picture, "png")
    return files
