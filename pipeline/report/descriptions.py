"""What the plots of the page show, in words and numbers, for those who cannot see them."""

import numpy as np

from pipeline.machine.geometry import MODES
from pipeline.report.data import Motion, Proof, Report, Scene
from pipeline.report.wording import signed


def describe_plots(report: Report) -> dict[str, str]:
    """Describe every plot that the scripts draw, by the identifier of its element."""
    described = {} if report.proof is None else {"proof": _proof(report.proof)}
    if report.motions:
        motion = report.motions[0]
        described |= {
            "machine": f"{_machine(motion)}{_bodies(motion, report.scene)}",
            "map": _map(motion),
            "timeline": _timeline(motion),
        }
    return described


def _machine(motion: Motion) -> str:
    return (
        "The machine in 3-D at the chosen time: three carts on parallel rails, six links, two of them telescopes, and "
        f"the platform. In {motion.t_s[-1]:.2f} s the TCP moves from {_place(motion, 0)} to {_place(motion, -1)}, and "
        f"the working mode changes from {_mode(motion, 0)} to {_mode(motion, -1)}."
    )


def _bodies(motion: Motion, scene: Scene) -> str:
    if not motion.nearest:
        return ""
    i = int(np.min([group.distance_m for group in motion.nearest], axis=0).argmin())
    pair, distance_m = motion.nearest_at(i)
    return f" Of its bodies, {scene.pair_names[pair]} come closest: {1e3 * distance_m:.1f} mm at {motion.t_s[i]:.2f} s."


def _map(motion: Motion) -> str:
    singular, maps = sum(len(loop) > 0 for loop in motion.maps.loops), len(motion.maps.titles)
    return (
        "Map of κ over the YZ plane, for the tilt and working mode at the chosen time, with the TCP path and the "
        f"curves where the machine is singular; {singular} of the {maps} maps of this motion have such curves. "
        f"Along the motion κ stays between {motion.kappa.min():.1f} and {motion.kappa.max():.1f}."
    )


def _timeline(motion: Motion) -> str:
    worst = int(np.argmax(motion.kappa))
    changes = np.flatnonzero(np.diff(motion.modes)) + 1
    modes = "; ".join(f"{_mode(motion, i)} from {motion.t_s[i]:.2f} s" for i in changes.tolist()) or "no change"
    speed = np.abs(motion.qd_mps)
    bodies = "distances of the nearest bodies, " if motion.nearest else ""
    return (
        f"κ, {bodies}position and tilt of the TCP, and positions and velocities of carts and telescopes over time. "
        f"κ peaks at {motion.kappa[worst]:.1f} at {motion.t_s[worst]:.2f} s. "
        f"Working modes: {_mode(motion, 0)} at the start; {modes}. "
        f"Peak velocity of a cart {speed[:, :3].max():.2f} m/s, of a telescope {speed[:, 3:].max():.2f} m/s."
    )


def _proof(proof: Proof) -> str:
    known = np.isfinite(proof.bound)
    bound = f"at most {proof.bound.max():.2f}" if known.all() else f"missing in {np.count_nonzero(~known)} of them"
    return (
        f"The proven bound of κ over {len(proof.bound)} boxes, {bound}, and the sampled κ, at most "
        f"{proof.kappa.max():.2f}, along the {proof.length[-1]:.1f} steps of the path. "
        f"The bound is above all samples, by {100.0 * proof.least_excess:.3f} % or more."
    )


def _mode(motion: Motion, i: int) -> str:
    return MODES[int(motion.modes[i])]


def _place(motion: Motion, i: int) -> str:
    x, y, z = (signed(value, ".2f") for value in motion.pose[i, :3])
    return f"({x}, {y}, {z}) m"
