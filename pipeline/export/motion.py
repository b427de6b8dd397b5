"""A motion of the actuators as it is read back from any format."""

from dataclasses import dataclass

from pipeline.arrays import FloatArray


@dataclass(frozen=True, eq=False)
class Motion:
    """Positions of the actuators over time, with whatever else the format has.

    Attributes
    ----------
    t_s : (n,)
        Time since the start.
    q_m : (n, 5)
        c1, c2, c3, l2b, l3b.
    qd_mps, qdd_mps2 : (n, 5) or None
        Their velocities and accelerations; None where a format leaves them out.
    joint_names : tuple of str
        Names of the actuators; empty where a format leaves them out.
    """

    t_s: FloatArray
    q_m: FloatArray
    qd_mps: FloatArray | None = None
    qdd_mps2: FloatArray | None = None
    joint_names: tuple[str, ...] = ()
