"""The proven error of the tool along the path, with samples under the bound."""

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pipeline.arrays import FloatArray
from pipeline.figures import style
from pipeline.inclusion.uncertainty import Uncertainty
from pipeline.machine.geometry import ACTUATORS
from pipeline.pose_error import PoseError, SampledError

_COLOURS = (style.BLUE, style.ORANGE, style.GREEN, style.VERMILLION, style.PURPLE)

_WIDEST = 50
"""Characters that fit above a panel."""


@style.styled
def pose_error_figure(found: PoseError, sampled: SampledError) -> Figure:
    """Draw the bounds of position and rotation over s, with samples, and the amplification of each drive below."""
    figure = style.new_figure(4.2)
    position, rotation, amplified = figure.subplots(3, 1, sharex=True)
    _bound(position, found.edges, 1e3 * found.position_m)
    position.plot(sampled.s, 1e3 * sampled.position_m, ".", color=style.REFINED, markersize=1.5)
    position.set_ylabel("position (mm)")
    position.set_title(_errors(found.uncertainty), loc="left")
    _bound(rotation, found.edges, 1e3 * found.rotation_rad)
    rotation.plot(sampled.s, 1e3 * sampled.rotation_rad, ".", color=style.REFINED, markersize=1.5, label="samples")
    rotation.set_ylabel("rotation (mrad)")
    for name, values, colour in zip(ACTUATORS, found.amplification.position.T, _COLOURS, strict=True):
        amplified.stairs(values, found.edges, baseline=None, color=colour, linewidth=0.8, label=name)
    amplified.set_ylabel("tool per drive\n(mm per mm)")
    amplified.set_xlabel("s")
    amplified.set_xlim(0.0, 1.0)
    for axes in (position, rotation, amplified):
        axes.set_ylim(bottom=0.0)
    figure.align_ylabels([position, rotation, amplified])
    handles = [*rotation.get_legend_handles_labels()[0], *amplified.get_legend_handles_labels()[0]]
    figure.legend(handles=handles, loc="outside lower center", ncols=4)
    return figure


def _bound(axes: Axes, edges: FloatArray, bound: FloatArray) -> None:
    axes.stairs(bound, edges, baseline=None, color=style.BLACK, linewidth=0.9, label="proven bound")


def _errors(uncertainty: Uncertainty) -> str:
    """Say what is off, and by how much."""
    drives = [f"{1e3 * error:g}" for error in uncertainty.actuator_m]
    same = drives[:1] if len(set(drives)) == 1 else drives
    parts = [f"drives ±{', '.join(same)} mm"] if any(uncertainty.actuator_m) else []
    parts += [f"lengths ±{1e3 * uncertainty.length_m:g} mm"] if uncertainty.length_m else []
    parts += [f"coordinates ±{1e3 * uncertainty.coordinate_m:g} mm"] if uncertainty.coordinate_m else []
    line = "; ".join(parts)
    return line if len(line) <= _WIDEST else "\n".join((parts[0], "; ".join(parts[1:])))
