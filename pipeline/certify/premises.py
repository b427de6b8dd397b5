"""What a proof rests on apart from the path: the machine, the limits and both ends, as one hash."""

from pipeline.config import Config
from pipeline.config.file import config_sha256
from pipeline.config.machine.links import SHARED_JOINT_M
from pipeline.limits import KINDS


def premises_sha256(config: Config) -> str:
    """Hash the machine's geometry and clearance, the values that the proven limits follow from, and start and goal.

    These are the configured values, not numbers computed from them, so that every processor finds the same hash.
    """
    machine = config.machine.model_dump(mode="json")
    if config.machine.clearance.shared_joint_m == SHARED_JOINT_M:
        # Certificates of versions without this key stay valid.
        del machine["clearance"]["shared_joint_m"]
    task = config.task.model_dump(mode="json")
    limits: dict[str, object] = {}
    for kind in KINDS:
        limits |= kind.CERTIFICATE.premises(config)
    return config_sha256(
        {
            "machine": {
                key: machine[key]
                for key in ("rails", "links", "triangle_branch", "characteristic_length_m", "clearance")
            },
            "ends": [task["start"], task["goal"]],
            "limits": limits,
        }
    )
