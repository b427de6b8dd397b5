"""The same machine and task in another size."""

from typing import Any

from pipeline.config import Config
from pipeline.config.file import parse_config


def scaled(config: Config, k: float) -> Config:
    """Multiply every length of a configuration by k: its keys end in _m, or are within a key that does."""
    return parse_config(_scaled(config.model_dump(mode="json"), k, in_metres=False))


def _scaled(value: Any, k: float, in_metres: bool) -> Any:
    if isinstance(value, dict):
        return {key: _scaled(item, k, in_metres or key.endswith("_m")) for key, item in value.items()}
    if isinstance(value, list):
        return [_scaled(item, k, in_metres) for item in value]
    return k * value if in_metres and value is not None else value
