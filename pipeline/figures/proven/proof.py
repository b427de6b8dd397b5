"""The certificate against the samples: the proven bound of kappa over every box, and kappa itself."""

import numpy as np
from matplotlib.figure import Figure

from pipeline.arrays import FloatArray, IntArray
from pipeline.certify.recheck import KappaProfile
from pipeline.config import Config
from pipeline.figures import style
from pipeline.machine.statics import moment_unit
from pipeline.refine.measure import PathSamples
from pipeline.route.metric import arc_length, step_sizes


@style.styled
def proof_figure(config: Config, refined: PathSamples, profile: KappaProfile) -> Figure:
    """Draw the bound of kappa over each box, and the sampled kappa, over the path length; below, their difference.

    The difference is that of a box's bound and each sample within it, in per cent of the sample: always above zero.
    """
    length = arc_length(refined.pose, step_sizes(config.route))
    edges = np.interp(profile.edges, refined.s, length)
    box = boxes_of(profile, refined.s)
    figure = style.new_figure(3.0)
    top, bottom = figure.subplots(2, 1, sharex=True, height_ratios=[1.0, 0.6])
    bound = f"proven bound over each of {len(profile.kappa)} boxes"
    top.stairs(profile.kappa, edges, baseline=None, color=style.BLUE, linewidth=0.9, label=bound)
    top.plot(length, refined.kappa, color=style.REFINED, label="refined path, sampled")
    top.set_ylabel(f"κ ({moment_unit(refined.machine)})")
    bottom.plot(length, 100.0 * (profile.kappa[box] / refined.kappa - 1.0), color=style.BLUE, linewidth=0.7)
    bottom.set_ylim(bottom=0.0)
    bottom.set_ylabel("bound above\nsampled κ (%)")
    bottom.set_xlabel(style.LENGTH_LABEL)
    bottom.set_xlim(0.0, length[-1])
    figure.align_ylabels([top, bottom])
    figure.legend(handles=top.get_legend_handles_labels()[0], loc="outside lower center", ncols=1)
    return figure


def boxes_of(profile: KappaProfile, s: FloatArray) -> IntArray:
    """Find the box that each s (n,) is in; at an edge, the one after it. Shape (n,)."""
    return np.clip(np.searchsorted(profile.edges, s, side="right") - 1, 0, len(profile.kappa) - 1)
