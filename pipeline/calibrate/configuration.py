"""A calibrated machine as a configuration: the keys that change, in the user's own file."""

from typing import Any

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.calibrate.model.model import Model
from pipeline.calibrate.model.parameters import FIXED
from pipeline.calibrate.model.rails import Rails
from pipeline.calibrate.yaml_edit import with_values
from pipeline.config import Config
from pipeline.config.file import parse_config
from pipeline.config.machine.links import STEEPEST_SLOPE
from pipeline.errors import ConfigError, UsageError
from pipeline.machine.clearance import link_pairs
from pipeline.machine.geometry import ACTUATORS, ARM_OF_LINK, LINKS, build_machine
from pipeline.yaml_text import YamlError, parse_yaml

_DECIMALS = 9
"""Nanometres."""
_SLOPE_DECIMALS = 12
"""Much less than a nanometre along a rail."""


def calibrated_yaml(text: str, config: Config, model: Model, heading: str) -> str:
    """Write a machine into the text of its configuration, with a comment above; all else stays as it is.

    Raises
    ------
    UsageError
        When the machine cannot be written there: rails that are too far off X, or a text that says the same of several
        parts of the machine by an anchor.
    """
    steepest = float(np.abs(model.directions_rad).max())
    if steepest > STEEPEST_SLOPE:
        raise UsageError(
            f"a rail is {1e3 * steepest:.2f} mm per metre off X; a configuration has rails that are at most "
            f"{1e3 * STEEPEST_SLOPE:g} off.\n  What to change: align the rails."
        )
    changes = calibrated_keys(config, model)
    try:
        new = f"# {heading}\n{with_values(text, changes)}"
        written = parse_config(parse_yaml(new), default_name=config.name or "run")
    except (ValueError, YamlError, ConfigError) as error:
        raise _unfit(str(error)) from None
    wanted = _merged(config.model_dump(mode="json"), changes)
    if written.model_copy(update={"name": config.name}) != parse_config(wanted, default_name=config.name or "run"):
        raise _unfit("a part of the file is used in several places (by an anchor, & and *)")
    return new


def _unfit(why: str) -> UsageError:
    return UsageError(
        f"the calibrated machine cannot be written into the configuration as it is: {why}.\n"
        "  What to change: write out its section machine (gantry-tau check CONFIG --yaml)."
    )


def calibrated_keys(config: Config, model: Model) -> dict[str | int, Any]:
    """Give the keys of a configuration that change where a calibrated machine is written into it."""
    links: dict[str | int, Any] = {}
    for index, link in enumerate(LINKS):
        links[f"l{link}"] = {
            "platform_point_m": _rounded(model.platform_points_m[index]),
            "cart_offset_m": _rounded(model.cart_offsets_m[index]),
        }
        if index in FIXED:
            links[f"l{link}"]["length_m"] = _rounded(model.lengths_m[index])
    on_rails = Rails(
        model.rails_m, model.directions_rad, model.middles_m[:3], model.zeros_m[:3], model.scales[:3]
    ).at_origin()
    zeros, scales = np.append(on_rails.zeros_m, model.zeros_m[3:]), np.append(on_rails.scales, model.scales[3:])
    machine: dict[str | int, Any] = {
        "rails": {arm: _rail_keys(config, on_rails, arm) for arm in range(len(model.rails_m))},
        "links": links,
        "actuators": {
            name: {"zero_m": _rounded(zeros[k]), "scale": _rounded(scales[k])} for k, name in enumerate(ACTUATORS)
        },
    }
    apart = _shared_joints(config, model)
    if apart > config.machine.clearance.shared_joint_m:
        machine["clearance"] = {"shared_joint_m": float(np.ceil(1e3 * apart) / 1e3)}
    changed: dict[str | int, Any] = _changed(config.model_dump(mode="json"), {"machine": machine})
    # A right angle between 3a and the platform side gives 3c its length, but not the length it has.
    is_right_angled = config.machine.links.l3c.length_m is None
    derived = {"machine": {"links": {"l3c": {"length_m": links["l3c"]["length_m"]}}}}
    return {} if is_right_angled and changed == derived else changed


def _rail_keys(config: Config, rails: Rails, arm: int) -> dict[str | int, Any]:
    y, z = rails.places_m[arm]
    keys: dict[str | int, Any] = {"y_m": _rounded(y), "z_m": _rounded(z)}
    slopes = (np.round(rails.slopes[arm], _SLOPE_DECIMALS) + 0.0).tolist()
    return {**keys, "slopes": slopes} if any(slopes) or any(config.machine.rails[arm].slopes) else keys


def _shared_joints(config: Config, model: Model) -> float:
    """How far apart the joints are that were one in the machine as configured."""
    machine = build_machine(config.machine)
    apart, pairs = [0.0], link_pairs(machine)
    for a in range(len(LINKS)):
        for b in range(a + 1, len(LINKS)):
            if (a, b) not in pairs:
                ends = [(machine.platform_points_m, model.platform_points_m)]
                ends += [(machine.cart_offsets_m, model.cart_offsets_m)] if ARM_OF_LINK[a] == ARM_OF_LINK[b] else []
                apart += [
                    float(np.linalg.norm(now[a] - now[b]))
                    for before, now in ends
                    if np.linalg.norm(before[a] - before[b]) <= machine.shared_joint_m
                ]
    return max(apart)


def _rounded(value: FloatArray | float) -> Any:
    return (np.round(value, _DECIMALS) + 0.0).tolist()


def _changed(data: Any, keys: Any) -> Any:
    """Leave out keys whose values are those of the configuration."""
    inner = {key: _changed(data[key], value) if isinstance(value, dict) else value for key, value in keys.items()}
    return {
        key: value
        for key, value in inner.items()
        if value != {} and (isinstance(value, dict) or value != (data[key] if isinstance(key, int) else data.get(key)))
    }


def _merged(data: Any, changes: Any) -> Any:
    """Change values deep in nested sections and lists."""
    if not isinstance(changes, dict):
        return changes
    if isinstance(data, list):
        return [_merged(item, changes[index]) if index in changes else item for index, item in enumerate(data)]
    return {**data, **{key: _merged(data.get(key), value) for key, value in changes.items()}}
