"""What the drives feel over time: reflected mass, stiffness by gravity, damping by motion, amplification to the TCP."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from pipeline.arrays import FloatArray
from pipeline.figures import style
from pipeline.machine.geometry import ACTUATORS
from pipeline.retime.quality.drives import measure_drives
from pipeline.retime.result import Trajectory

_COLOURS = (style.BLUE, style.ORANGE, style.GREEN, style.VERMILLION, style.PURPLE)
_KILO = 1e-3


def has_masses(trajectory: Trajectory) -> bool:
    """Check whether the drives have anything to move: the machine's masses are known."""
    return trajectory.path.machine.masses is not None


@style.styled
def drives_figure(trajectory: Trajectory) -> Figure:
    """Draw reflected masses, least stiffness and damping, and amplification over time.

    Masses are those of each drive while the others hold their positions, and the largest in any direction of actuator
    space. Stiffness is the least eigenvalue of dF/dq of the holding forces, with its limit dashed where it is in sight;
    damping that of the symmetric part of dF/dqd in motion. Below zero, what a drive has to make up for is shaded.

    Raises
    ------
    ValueError
        For a machine without masses.
    """
    drives = measure_drives(trajectory)
    if drives.felt is None:
        raise ValueError("without masses there are no figures of the drives to draw")
    felt, amplified = drives.felt, drives.amplified
    figure = style.new_figure(4.4)
    masses, stiffness, damping, gains = figure.subplots(4, 1, sharex=True, height_ratios=(1.5, 1.0, 1.0, 1.0))
    for column, colour, name in zip(felt.reflected_mass_kg.T, _COLOURS, ACTUATORS, strict=True):
        masses.plot(drives.t_s, column, color=colour, linewidth=0.8, label=name)
    masses.plot(drives.t_s, felt.worst_mass_kg.value, color=style.BLACK, linewidth=0.8, label="worst direction")
    masses.set_yscale("log")
    masses.set_ylabel("reflected\nmass (kg)")
    style.name_lines(masses, 6)
    least = trajectory.path.machine.gravity_stiffness_npm
    _draw_signed(stiffness, drives.t_s, _KILO * felt.stiffness_npm.value, "gravity\nstiffness (kN/m)")
    if np.isfinite(least) and least >= 2.0 * felt.stiffness_npm.value.min():
        stiffness.axhline(_KILO * least, **style.LIMIT_LINE)
    _draw_signed(damping, drives.t_s, _KILO * felt.damping_nspm.value, "damping by\nmotion (kNs/m)")
    gains.plot(drives.t_s, amplified.position.value, color=style.BLUE, linewidth=0.8, label="position (mm/mm)")
    gains.plot(drives.t_s, amplified.angle.value, color=style.ORANGE, linewidth=0.8, label="angle (mrad/mm)")
    # Room for the names of the curves above them.
    gains.set_ylim(0.0, 1.35 * gains.get_ylim()[1])
    gains.set_ylabel("TCP per\nactuators")
    gains.legend(loc="upper left", ncols=2)
    gains.set_xlabel("time (s)")
    gains.set_xlim(0.0, float(drives.t_s[-1]))
    figure.align_ylabels([masses, stiffness, damping, gains])
    return figure


def _draw_signed(axes: Axes, t_s: FloatArray, values: FloatArray, label: str) -> None:
    axes.plot(t_s, values, color=style.VERMILLION, linewidth=0.8)
    axes.fill_between(t_s, np.minimum(values, 0.0), color=style.VERMILLION, alpha=0.25, linewidth=0.0)
    axes.set_ylabel(label)
    axes.yaxis.set_major_locator(MaxNLocator(4))
