"""The whole of `summary.json`."""

from collections.abc import Mapping

from pipeline.config import Config
from pipeline.config.file import config_sha256
from pipeline.summary.section import Section
from pipeline.summary.versions import versions


def summarise(config: Config, sections: Mapping[str, Section]) -> Section:
    """Put the parts of all stages together, with the configuration's hash and the versions."""
    return {"name": config.name, "config_sha256": config_sha256(config), "versions": versions(), **sections}
