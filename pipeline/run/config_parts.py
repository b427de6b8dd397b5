"""The part of the configuration that each stage may read: only a change in it makes the stage run again.

Regions and route depend on limits and masses only as far as forces have to hold the machine (a route by time on
velocity limits, too), and the path on velocity limits beside them, in whose units it is smooth: other limits of motion
only cost a new trajectory. Where path and time law are found together, stage two depends on all limits and masses, and
on whether jerk is limited. The files of the last stages quote the configuration with its name and hash, so that these
depend on all of it; how results are drawn is no part of the hash, and costs new figures alone.
"""

from typing import Any

from pipeline.config import Config
from pipeline.config.choices import BodyFrame, PathObjective, Proof, RouteObjective

_OF_MOTION = ("limits", "dynamics")
"""Parts of the machine of which stages one and two read what holds it, and no more."""
_TOLERANCES_ONLY = ("tolerance_resolution", "monte_carlo_samples")
"""Keys of the proof that only the search for tolerances reads."""

_MARGINS = ("travel_margin_m", "stroke_margin_m")
"""Keys of stage two that its route keeps, too."""
_DIRECTIONS = ("start_direction", "goal_direction")
"""Keys of stage two that say, with `approach_m`, between which poses its route is planned."""

Part = dict[str, Any]


def whole_config(config: Config) -> Part:
    """Give all keys of a run; those of an atlas are not."""
    return config.model_dump(mode="json", exclude={"atlas"})


def regions_part(config: Config) -> Part:
    """Give the keys that the region table depends on."""
    whole = whole_config(config)
    # The margin around boxes to avoid and obstacles is measured in steps.
    machine, task = config.machine, config.task
    fixed = any(body.attached_to == BodyFrame.FRAME and body.beam is None for body in machine.bodies)
    margin = ("avoid_margin", "x_step_m") if task.avoid or task.obstacles or fixed else ()
    return {
        "machine": _machine_part(config),
        "task": _without(whole["task"], "budget"),
        "route": {key: whole["route"][key] for key in ("grid", "kappa_max", *margin)},
        "refine": _of_refine(config),
    }


def grid_part(config: Config) -> Part:
    """Give the keys that the regions of grid and gates depend on: not start, goal, name and limits of motion."""
    part = regions_part(config)
    return {
        "machine": part["machine"],
        "task": {key: part["task"][key] for key in ("tilt_max_deg", "locked_axes")},
        "route": {key: part["route"][key] for key in ("grid", "kappa_max")},
        "refine": {key: part["refine"][key] for key in _MARGINS},
    }


def route_part(config: Config) -> Part:
    """Give the keys that the route depends on."""
    whole, machine = whole_config(config), _machine_part(config)
    if config.route.objective == RouteObjective.TIME:
        machine = _joined(machine, {"limits": _only("velocity_mps", whole["machine"]["limits"])})
    return {"machine": machine, "task": whole["task"], "route": whole["route"], "refine": _of_refine(config)}


def refine_part(config: Config) -> Part:
    """Give the keys that the refined path depends on; with its time law, on masses and all limits of motion, too."""
    part, whole = route_part(config), whole_config(config)
    limits = whole["machine"]["limits"]
    if config.refine.objective == PathObjective.TIME:
        part = {**part, "machine": whole["machine"], "retime": _only("jerk", whole["retime"])}
    elif config.refine.smoothness > 0.0:
        part["machine"] = _joined(part["machine"], {"limits": _only("velocity_mps", limits)})
    return {**part, "refine": whole["refine"]}


def certify_part(config: Config) -> Part:
    """Give the keys that the certificate depends on."""
    not_read = () if config.certify.what in (Proof.TOLERANCES, Proof.FOLLOWING) else _TOLERANCES_ONLY
    return {**refine_part(config), "certify": _without(whole_config(config)["certify"], *not_read)}


def retime_part(config: Config) -> Part:
    """Give the keys that the trajectory, and what it quotes, depends on."""
    return _without(whole_config(config), "figures")


def with_proof(config: Config, what: Proof) -> Config:
    """Give the configuration with another proof."""
    return config.model_copy(update={"certify": config.certify.model_copy(update={"what": what})})


def with_sufficient_proofs(config: Config) -> tuple[Config, ...]:
    """Give the configurations whose certificates prove at least what is asked for, the least first."""
    proofs = list(Proof)
    return tuple(with_proof(config, what) for what in proofs[proofs.index(config.certify.what) :])


def _of_refine(config: Config) -> Part:
    keys = (*_MARGINS, "approach_m", *(_DIRECTIONS if config.refine.approach_m is not None else ()))
    return {key: value for key, value in whole_config(config)["refine"].items() if key in keys}


def _machine_part(config: Config) -> Part:
    machine = _without(whole_config(config)["machine"], *_OF_MOTION)
    return {**machine, **config.machine.holding()}


def _without(section: Part, *keys: str) -> Part:
    return {key: value for key, value in section.items() if key not in keys}


def _only(wanted: str, section: Part) -> Part:
    """Give a key of a section and of the sections in it."""
    inner = {key: _only(wanted, value) for key, value in section.items() if isinstance(value, dict)}
    found = {wanted: section[wanted]} if wanted in section else {}
    return found | {key: value for key, value in inner.items() if value}


def _joined(first: Part, second: Part) -> Part:
    """Join two sections, and the sections in them."""
    inner = {
        key: _joined(first[key], value)
        for key, value in second.items()
        if isinstance(value, dict) and isinstance(first.get(key), dict)
    }
    return {**first, **second, **inner}
