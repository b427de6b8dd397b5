"""Where links sweep in the platform's frame along a run's path: what a tool has to keep clear of.

`python -m tests.benchmarks.swept RUN PICTURE` cuts the links by planes across the tool's axis, and draws the platform's
bodies on that axis as circles.
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from pipeline import Results, open_results, sample_path
from pipeline.arrays import FloatArray
from pipeline.config.machine.bodies import LINK_NAMES
from pipeline.machine.bodies.placement import Frames
from pipeline.machine.samples import PoseSamples
from pipeline.machine.shapes.model import FrameKind, SweptHull

PLANES_M = (0.0, 0.07, 0.17, 0.27, 0.45, 0.6)
SAMPLES = 2_000
_REACH_M = 0.3


def joints_along(results: Results) -> tuple[FloatArray, FloatArray]:
    """Give platform and cart joints of the links in the platform's frame, both (samples, 6, 3)."""
    machine = results.machine
    samples = sample_path(results.refinement.path, np.linspace(0.0, 1.0, SAMPLES))
    frames = Frames.of(machine, samples.pose, PoseSamples(machine, samples.pose, samples.q_m).carts_m)
    carts = frames.joints_m - frames.tcp_m
    platform, cart = (np.einsum("jin,ljn->nli", frames.rotation, part) for part in (carts + frames.vectors_m, carts))
    return platform, cart


def cut(platform: FloatArray, cart: FloatArray, y_m: float) -> FloatArray:
    """Give x and z of a link (n, 3), (n, 3) in a plane, where it meets it."""
    part = (y_m - platform[:, 1]) / (cart - platform)[:, 1]
    meets = (part >= 0.0) & (part <= 1.0)
    return (platform + part[:, None] * (cart - platform))[meets][:, [0, 2]]


def picture(results: Results) -> Figure:
    """Draw one plane beside the other."""
    platform, cart = joints_along(results)
    bodies = results.machine.bodies
    on_axis = [] if bodies is None else [hull for hull in bodies.hulls if _is_on_axis(hull)]
    figure, grid = plt.subplots(2, 3, figsize=(9.0, 6.6), sharex=True, sharey=True, layout="constrained")
    for axes, y_m in zip(grid.flat, PLANES_M, strict=True):
        for link, name in enumerate(LINK_NAMES):
            x, z = cut(platform[:, link], cart[:, link], y_m).T
            axes.plot(x, z, ".", markersize=2, color=f"C{link}", label=name[1:])
        for hull in on_axis:
            if hull.points_m[:, 1].min() <= y_m <= hull.points_m[:, 1].max():
                axes.add_patch(plt.Circle((0.0, 0.0), hull.radius_m, color="0.6"))
        axes.set(title=f"y = {y_m:g} m", xlim=(-_REACH_M, _REACH_M), ylim=(-_REACH_M, _REACH_M), aspect="equal")
    for axes in grid[1]:
        axes.set_xlabel("x (m)")
    for axes in grid[:, 0]:
        axes.set_ylabel("z (m)")
    figure.legend(*grid[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=6, markerscale=5)
    return figure


def _is_on_axis(hull: SweptHull) -> bool:
    return hull.kind == FrameKind.PLATFORM and not hull.points_m[:, [0, 2]].any()


if __name__ == "__main__":
    picture(open_results(Path(sys.argv[1]))).savefig(sys.argv[2], dpi=100)
