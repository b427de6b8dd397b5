"""The configuration written with every key and its meaning."""

import yaml

from pipeline.config import Config
from pipeline.config.commented import commented_yaml
from pipeline.config.file import parse_config


def test_it_is_read_back(agder_config: Config, vary):
    """Comments change nothing, whatever is asked for."""
    visit = [{"box": {"x_m": [0.8, 0.9]}, "modes": ["RLL"]}]
    for config in (agder_config, vary(agder_config, {"task.visit": visit, "retime.jerk": False})):
        assert parse_config(yaml.safe_load(commented_yaml(config))) == config


def test_every_key_is_there_with_its_description(agder_config: Config):
    """Descriptions are those of the schema, which editors show, too."""
    words = " ".join(line.strip().lstrip("# ") for line in commented_yaml(agder_config).splitlines())
    for section in ("task", "route", "refine", "certify", "bound", "retime", "figures", "export", "drives"):
        for name, field in type(getattr(agder_config, section)).model_fields.items():
            assert f"{name}:" in words
            if field.description:
                assert field.description in words


def test_lines_are_short(agder_config: Config):
    """They fit on a page."""
    assert max(map(len, commented_yaml(agder_config).splitlines())) <= 118
