"""Configurations that come with the program."""

from importlib import resources

from pipeline.config.config import Config
from pipeline.config.file import parse_config
from pipeline.yaml_text import parse_yaml


def packaged_config(base: str, name: str) -> Config:
    """Read the configuration `base`, named like its file without the ending, under a name made from `name`."""
    text = (resources.files("pipeline") / "configs" / f"{base}.yaml").read_text(encoding="utf-8")
    return renamed(parse_config(parse_yaml(text), source=base), name)


def renamed(config: Config, name: str) -> Config:
    """Give a configuration with a name made from `name`: what a name may not have becomes a dash."""
    return parse_config({**config.model_dump(mode="json"), "name": ""}, default_name=name)
