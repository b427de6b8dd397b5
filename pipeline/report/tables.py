"""The tables of a report: coarse against refined, what is proven, the usable workspace, versions and hashes."""

import base64
import io

import numpy as np

from pipeline.certify.endpoints import TOLERANCE as END_TOLERANCE
from pipeline.certify.recheck import KappaProfile
from pipeline.certify.result import Bounds
from pipeline.compare.metrics import TABLE_HEADER, ComparisonRow, table_cells
from pipeline.config import Config
from pipeline.figures.maps.volume import workspace_volume_figure
from pipeline.figures.proof import boxes_of
from pipeline.limits.kappa import path_cap
from pipeline.limits.tilt import path_limits_deg
from pipeline.machine.geometry import ACTUATORS, Machine
from pipeline.refine.measure import PathSamples
from pipeline.report.data import Proof, Table
from pipeline.route.metric import arc_length, step_sizes
from pipeline.workspace.table import TABLE_HEADER as WORKSPACE_HEADER
from pipeline.workspace.table import at_two_steps, setting_text, workspace_rows
from pipeline.workspace.table import table_cells as workspace_cells
from pipeline.workspace.usable import WorkspaceSetting

_WORKSPACE_STEP_M = 0.01
_PROOF_SAMPLES = 1_000
_SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def comparison_table(rows: list[ComparisonRow]) -> Table:
    """Put coarse and refined beside each other, the better one named."""
    cells = tuple((row[0], _unit(row[1]), *(cell.replace("-", "−") for cell in row[2:])) for row in table_cells(rows))
    return Table(TABLE_HEADER, cells, words=(0, 1, 6))


def _unit(text: str) -> str:
    return text.replace("^2", "²").replace("^3", "³")


def workspace_part(machine: Machine) -> tuple[Table, str]:
    """Compute what every working mode can use without tilt, and all of them together; and draw it, a PNG in base64."""
    setting = WorkspaceSetting(step_m=_WORKSPACE_STEP_M)
    fine, coarse = at_two_steps(machine, setting)
    rows = workspace_rows(fine, coarse)
    table = Table(
        header=tuple(_unit(heading) for heading in WORKSPACE_HEADER),
        rows=tuple((row[0], *(cell.replace("-", "−") for cell in row[1:])) for row in workspace_cells(rows)),
        words=(0,),
        note=setting_text(machine, setting),
    )
    picture = io.BytesIO()
    workspace_volume_figure(machine, fine).savefig(picture, format="png")
    return table, base64.b64encode(picture.getvalue()).decode()


def bounds_table(config: Config, machine: Machine, bounds: Bounds) -> Table:
    """Put what is proven for every point of the path beside what is allowed."""
    rows = [
        ("κ", f"at most {bounds.kappa:.3f}", f"at most {path_cap(config):g}"),
        ("sign of det H", f"{bounds.det_sign:+d} everywhere".replace("-", "−"), "never changes"),
    ]
    for name, bound, limits in zip(ACTUATORS, bounds.actuators_m, machine.actuator_limits_m, strict=True):
        rows.append((name, f"{bound[0]:.4f} to {bound[1]:.4f} m", f"{limits[0]:g} to {limits[1]:g} m"))
    tilts = zip(("|rx|", "|rz|"), np.rad2deg(bounds.tilt_rad), path_limits_deg(config), strict=True)
    rows += [(name, f"at most {tilt:.2f}°", f"at most {limit:g}°") for name, tilt, limit in tilts]
    if len(bounds.pairs):
        rows.append(("least distance of axes", *_distance(machine, bounds, int(np.argmin(bounds.distances_m)))))
    for name, miss in (("start", bounds.start_miss), ("goal", bounds.goal_miss)):
        rows.append((f"{name} missed by", f"at most {_power(miss)} m or rad", f"at most {_power(END_TOLERANCE)}"))
    return Table(("quantity", "proven for the whole path", "allowed"), tuple(rows), words=(0, 1, 2))


def distances_table(machine: Machine, bounds: Bounds) -> Table:
    """Put the proven distance of every pair of axes beside what is allowed, the nearest first."""
    order = np.argsort(bounds.distances_m).tolist()
    rows = tuple((bounds.pairs[i], *_distance(machine, bounds, i)) for i in order)
    return Table(("axes of", "proven for the whole path", "allowed"), rows, words=(0, 1, 2))


def _distance(machine: Machine, bounds: Bounds, pair: int) -> tuple[str, str]:
    least = machine.link_rail_m if "rail" in bounds.pairs[pair] else machine.link_link_m
    return f"at least {bounds.distances_m[pair]:.5f} m", f"at least {least:g} m"


def _power(value: float) -> str:
    """Write a very small number as people do: 1.1·10⁻¹¹."""
    mantissa, exponent = f"{value:.1e}".split("e")
    return f"{mantissa}·10{str(int(exponent)).translate(_SUPERSCRIPT)}"


def build_proof(config: Config, refined: PathSamples, profile: KappaProfile) -> Proof:
    """Put the bound over each box above the sampled kappa; the curve is thinned, the comparison is of all samples."""
    length = arc_length(refined.pose, step_sizes(config.route))
    shown = np.linspace(0, len(length) - 1, min(_PROOF_SAMPLES, len(length))).round().astype(np.int64)
    shown = np.unique(np.append(shown, np.argmax(refined.kappa)))
    return Proof(
        edges=np.interp(profile.edges, refined.s, length),
        bound=profile.kappa,
        length=length[shown],
        kappa=refined.kappa[shown],
        least_excess=float((profile.kappa[boxes_of(profile, refined.s)] / refined.kappa - 1.0).min()),
    )
