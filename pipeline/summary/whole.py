"""The whole of `summary.json`."""

from collections.abc import Mapping

from pipeline.config import Config
from pipeline.config.file import config_sha256
from pipeline.summary.section import DRIVES, QUALITY, WORKSPACE, Section
from pipeline.summary.versions import versions


def summarise(config: Config, sections: Mapping[str, Section]) -> Section:
    """Put the parts of all stages together, with the configuration's hash and the versions."""
    parts = _with_own_parts(_with_quality_of_path(sections))
    return {"name": config.name, "config_sha256": config_sha256(config), "versions": versions(), **parts}


def _with_own_parts(sections: Mapping[str, Section]) -> dict[str, Section]:
    """Make parts of their own, after those of their stages, of what regions know of the workspace, timing of drives."""
    parts = {}
    for name, section in sections.items():
        parts[name] = {key: value for key, value in section.items() if key not in (DRIVES, WORKSPACE)}
        parts |= {key: section[key] for key in (DRIVES, WORKSPACE) if key in section}
    return parts


def _with_quality_of_path(sections: Mapping[str, Section]) -> dict[str, Section]:
    """Move what timing knows of the motion's quality into the part of the path, where the rest of it is."""
    parts = dict(sections)
    if QUALITY in (timed := parts.get("trajectory", {})) and QUALITY in (path := parts.get("path", {})):
        parts["path"] = {**path, QUALITY: path[QUALITY] | timed[QUALITY]}
        parts["trajectory"] = {key: value for key, value in timed.items() if key != QUALITY}
    return parts
