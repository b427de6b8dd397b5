"""The pictures of a report that no script draws, each with its description: workspace, route, what can be reached."""

import base64
import io
from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from pipeline.config import Config
from pipeline.figures.bodies import bodies_figure, has_pairs
from pipeline.figures.maps.route import route_figure
from pipeline.figures.maps.volume import workspace_volume_figure
from pipeline.figures.proven.pose_error import pose_error_figure
from pipeline.limits.bodies.pairs import kept_apart
from pipeline.machine.bodies.distances import least_distance
from pipeline.machine.geometry import MODES, Machine
from pipeline.pose_error import PoseError, SampledError
from pipeline.refine.measure import PathSamples
from pipeline.report.data import Picture, RoutePart, Table
from pipeline.report.wording import signed
from pipeline.route.result import Route
from pipeline.workspace.usable import Workspace


def picture_of(figure: Figure, alt: str) -> Picture:
    """Take a figure as a picture."""
    pixels = io.BytesIO()
    figure.savefig(pixels, format="png")
    return Picture(base64.b64encode(pixels.getvalue()).decode(), alt)


def workspace_picture(machine: Machine, workspace: Workspace) -> Picture:
    """Draw the usable workspace in 3-D."""
    volumes = workspace.volumes_m3
    left, right = (volumes[MODES.index(mode)] for mode in ("LLL", "RRR"))
    alt = (
        f"The usable volumes between the rails in 3-D: {left:.3f} m³ with all arms left (LLL), {right:.3f} m³ with all "
        f"arms right (RRR), {workspace.union_m3:.3f} m³ in all eight working modes together."
    )
    return picture_of(workspace_volume_figure(machine, workspace), alt)


def pairs_picture(config: Config, machine: Machine, refined: PathSamples) -> Picture | None:
    """Draw the distances of bodies along the path; None without bodies."""
    if not has_pairs(config, machine, refined):
        return None
    kept = kept_apart(config, machine)
    least = [(least_distance(bodies, refined), bodies is machine.bodies) for bodies in kept]
    nearest = " and ".join(
        f"{1e3 * value:.1f} mm {'between bodies' if own else 'from obstacles'}" for value, own in least
    )
    alt = (
        "The distances of all pairs of bodies that come near, over the length of the path, with the least that is "
        f"required, {1e3 * kept[0].clearance_m:g} mm. The least along the path are {nearest}; at each time the nearest "
        "pair is named beside the view of the machine."
    )
    return picture_of(bodies_figure(config, machine, refined), alt)


def pose_error_picture(found: PoseError, sampled: SampledError) -> Picture:
    """Draw the proven error of the tool, with samples."""
    worst, most = found.position_m.max(), found.rotation_rad.max()
    alt = (
        f"The proven error of the tool along the path, over s: at most {1e3 * worst:.3f} mm near s = "
        f"{found.middles[found.position_m.argmax()]:.2f}, and {1e3 * most:.3f} mrad near s = "
        f"{found.middles[found.rotation_rad.argmax()]:.2f}; the largest of {len(sampled.s)} samples are "
        f"{1e3 * sampled.position_m.max():.3f} mm and {1e3 * sampled.rotation_rad.max():.3f} mrad. Below, how far it "
        f"moves with each drive, up to {found.amplification.position.max():.1f} mm per mm."
    )
    return picture_of(pose_error_figure(found, sampled), alt)


def reach_picture(png: bytes, why_not: Sequence[str]) -> Picture:
    """Describe the picture of what can be reached by the findings that come with it."""
    reach = next((line for line in why_not if line.startswith("Reach: ")), "")
    alt = f"Regions in the YZ plane that can be reached from the start, and from which the goal can be reached. {reach}"
    return Picture(base64.b64encode(png).decode(), alt.strip())


def route_part(
    config: Config,
    machine: Machine,
    route: Route,
    samples: tuple[PathSamples, PathSamples] | None = None,
    drawn: bool = True,
) -> RoutePart:
    """Tabulate the steps of a route and, if `drawn`, draw them, with both paths if there are samples."""
    table = Table(
        ("step", "working mode", "x, m", "y, m", "z, m", "rx, °", "ry, °", "rz, °", "κ"),
        tuple(_step(route, i) for i in range(len(route))),
        words=(0, 1),
    )
    if not drawn:
        return RoutePart(table)
    coarse, refined = samples or (None, None)
    return RoutePart(table, picture_of(route_figure(config, machine, route, coarse, refined), _route_alt(route)))


def _step(route: Route, i: int) -> tuple[str, ...]:
    place = (signed(value, ".3f") for value in route.pose[i, :3])
    tilt = (signed(value, ".1f") for value in np.rad2deg(route.pose[i, 3:]))
    return (str(i), route.mode_names[i], *place, *tilt, f"{route.kappa[i]:.1f}")


def _route_alt(route: Route) -> str:
    names = route.mode_names
    modes = ", ".join(f"{name} from step {i}" for i, name in enumerate(names) if i == 0 or name != names[i - 1])
    worst = int(np.argmax(route.kappa))
    return (
        f"The {len(route)} steps of the route, each over the map of κ for its tilt and working mode: {modes}. "
        f"κ is largest at step {worst}, {route.kappa[worst]:.1f}. The table of steps has all poses."
    )
