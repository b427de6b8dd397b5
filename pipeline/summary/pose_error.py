"""The proven error of the tool in the summary."""

from typing import TYPE_CHECKING

from pipeline.summary.section import Section

if TYPE_CHECKING:
    from pipeline.pose_error import PoseError

_KEYS = (
    "pose_error_bound_m",
    "pose_error_bound_s",
    "pose_error_rotation_rad",
    "pose_error_rotation_s",
    "amplification_max",
    "amplification_max_s",
    "rotation_max_radpm",
)


def pose_error_part(found: "PoseError | None") -> Section:
    """Give the largest bounds, and the largest amplification by each drive, with their s; null if not asked for."""
    if found is None:
        return dict.fromkeys(_KEYS)
    amplified, middles = found.amplification, found.middles
    values = (
        float(found.position_m.max()),
        float(middles[found.position_m.argmax()]),
        float(found.rotation_rad.max()),
        float(middles[found.rotation_rad.argmax()]),
        amplified.position.max(axis=0).tolist(),
        middles[amplified.position.argmax(axis=0)].tolist(),
        amplified.rotation_radpm.max(axis=0).tolist(),
    )
    return dict(zip(_KEYS, values, strict=True))


def pose_error_words(section: Section) -> str:
    """Say the bounds in words; nothing if there are none."""
    if (bound := section.get("pose_error_bound_m")) is None:
        return ""
    return f"; the tool is off by {1e3 * bound:.3f} mm and {1e3 * section['pose_error_rotation_rad']:.3f} mrad at most"
