"""What a proof rests on besides the path: the machine, the limits and both ends, as one hash."""

from pipeline.config import Config
from pipeline.config.file import config_sha256
from pipeline.refine.path_limits import kappa_cap, tilt_limits_deg


def premises_sha256(config: Config) -> str:
    """Hash the machine's geometry and clearance, the limits of kappa and tilt, and start and goal, as configured.

    Of the configuration and not of the numbers computed from it, so that every processor finds the same hash.
    """
    machine = config.machine.model_dump(mode="json")
    task = config.task.model_dump(mode="json")
    return config_sha256(
        {
            "machine": {key: machine[key] for key in ("rails", "links", "triangle_branch", "clearance")},
            "ends": [task["start"], task["goal"]],
            "limits": {"kappa_max": kappa_cap(config), "tilt_deg": tilt_limits_deg(config)},
        }
    )
