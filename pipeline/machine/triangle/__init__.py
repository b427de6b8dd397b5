"""The dependent angle ry, which follows from the triangle of links 3a and 3c."""

from pipeline.machine.triangle.angle import dependent_angle
from pipeline.machine.triangle.closure import on_axis, third_discriminant

__all__ = ["dependent_angle", "on_axis", "third_discriminant"]
