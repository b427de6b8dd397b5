"""What a stage's result is made from, as one hash: as long as it stays, the result stays good."""

import functools
import hashlib
import pathlib
from collections.abc import Mapping
from typing import Any

from pipeline.config import Config
from pipeline.config_file import config_sha256
from pipeline.stage import Stage
from pipeline.summary import package_version

UPSTREAM: dict[Stage, tuple[Stage, ...]] = {
    Stage.REGIONS: (),
    Stage.ROUTE: (Stage.REGIONS,),
    Stage.REFINE: (Stage.ROUTE,),
    Stage.CERTIFY: (Stage.REFINE,),
    Stage.RETIME: (Stage.REFINE,),
    Stage.FIGURES: (Stage.REGIONS, Stage.ROUTE, Stage.REFINE, Stage.CERTIFY, Stage.RETIME),
}
"""The stages whose results a stage is given."""

_CODE = {
    Stage.REGIONS: ("artifacts", "machine", "route"),
    Stage.ROUTE: ("artifacts", "machine", "route"),
    Stage.REFINE: ("artifacts", "machine", "route", "solvers", "refine"),
    Stage.CERTIFY: ("artifacts", "machine", "route", "refine", "certify"),
    Stage.RETIME: ("artifacts", "machine", "refine", "solvers", "retime", "export"),
    Stage.FIGURES: ("artifacts", "machine", "route", "refine", "certify", "retime", "compare"),
}
_MOTION_ONLY = ("limits", "dynamics")
"""Parts of the machine that only its motion in time depends on."""
_PACKAGE = pathlib.Path(__file__).parents[1]


def config_part(config: Config, stage: Stage) -> dict[str, Any]:
    """Pick the keys of the configuration that a stage may read.

    Stages one and two know nothing of limits and masses, so that others cost a new trajectory only. The files of
    later stages quote the configuration, name and hash included, so that they depend on all of it.
    """
    whole = config.model_dump(mode="json")
    machine = {key: value for key, value in whole["machine"].items() if key not in _MOTION_ONLY}
    space = {"machine": machine, "task": whole["task"]}
    if stage is Stage.REGIONS:
        # The margin around boxes to avoid is counted in steps.
        margin = ("avoid_margin", "x_step_m") if config.task.avoid else ()
        route = {key: whole["route"][key] for key in ("grid", "kappa_max", *margin)}
        task = {key: value for key, value in whole["task"].items() if key != "budget"}
        return {"machine": machine, "task": task, "route": route}
    if stage is Stage.ROUTE:
        return {**space, "route": whole["route"]}
    if stage is Stage.REFINE:
        return {**space, "route": whole["route"], "refine": whole["refine"]}
    if stage is Stage.CERTIFY:
        return {**space, **{key: whole[key] for key in ("route", "refine", "certify")}}
    return whole


def grid_fingerprint(config: Config) -> str:
    """Hash all that the regions of grid and gates depend on: start, goal, name and limits are none of it."""
    space = config_part(config, Stage.REGIONS)
    return config_sha256(
        {
            "machine": space["machine"],
            "task": {key: space["task"][key] for key in ("tilt_max_deg", "locked_axes")},
            "route": {key: space["route"][key] for key in ("grid", "kappa_max")},
            "version": package_version(),
            "code": [_code_sha256(package) for package in _CODE[Stage.REGIONS]],
        }
    )


def fingerprint(config: Config, stage: Stage, upstream: Mapping[Stage, str]) -> str:
    """Hash a stage's part of the configuration, the results it is given, the package's version and its code.

    The code counts because a working copy changes far more often than its version does.

    Parameters
    ----------
    upstream : mapping
        Hash of the result of every stage in `UPSTREAM`.
    """
    return config_sha256(
        {
            "stage": stage,
            "config": config_part(config, stage),
            "upstream": {name: upstream[name] for name in UPSTREAM[stage]},
            "version": package_version(),
            "code": [_code_sha256(package) for package in _CODE[stage]],
        }
    )


@functools.cache
def _code_sha256(package: str) -> str:
    digest = hashlib.sha256()
    for source in sorted((_PACKAGE / package).rglob("*.py")):
        digest.update(source.relative_to(_PACKAGE).as_posix().encode())
        digest.update(source.read_bytes())
    return digest.hexdigest()
