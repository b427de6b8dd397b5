"""The tables of a report: coarse against refined, what is proven, the usable workspace, versions and hashes."""

import numpy as np

from pipeline.certify.bounds import Bounds
from pipeline.certify.endpoints import TOLERANCE as END_TOLERANCE
from pipeline.certify.recheck import KappaProfile
from pipeline.compare.metrics import TABLE_HEADER, ComparisonRow, table_cells
from pipeline.config import Config
from pipeline.figures.proven.proof import boxes_of
from pipeline.limits import CertificateKey, Side, certificate_keys, proven_limits
from pipeline.machine.actuator_space import mode_words
from pipeline.machine.geometry import ACTUATORS, Machine
from pipeline.refine.measure import PathSamples
from pipeline.report.data import Picture, Proof, Table
from pipeline.report.pictures import workspace_picture
from pipeline.report.wording import greek, true_minus
from pipeline.route.metric import arc_length, step_sizes
from pipeline.summary.section import SKIPPED, Section
from pipeline.workspace.table import TABLE_HEADER as WORKSPACE_HEADER
from pipeline.workspace.table import at_two_steps, setting_text, workspace_rows
from pipeline.workspace.table import table_cells as workspace_cells
from pipeline.workspace.usable import WorkspaceSetting, step_for

_WORKSPACE_STEP_M, _WORKSPACE_CELLS = 0.01, 100_000
_PROOF_SAMPLES = 1_000
_NEAREST = 12
"""Pairs whose proven distance is shown."""
_SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def comparison_table(rows: list[ComparisonRow]) -> Table:
    """Tabulate coarse against refined, naming the better one."""
    cells = tuple((greek(row[0]), _unit(row[1]), *(true_minus(cell) for cell in row[2:])) for row in table_cells(rows))
    return Table(TABLE_HEADER, cells, words=(0, 1, 6))


def quality_table(path: Section, motion: Section) -> Table:
    """Tabulate the sign changes and least times of the actuators from the parts of the summary that have them."""
    keys = ("velocity_sign_changes", "acceleration_sign_changes", "least_times_s")
    rows: list[tuple[str, ...]] = [
        (name, str(velocity), str(acceleration), f"{time_s:.2f}")
        for name, velocity, acceleration, time_s in zip(ACTUATORS, *(motion[key] for key in keys), strict=True)
    ]
    totals = (sum(motion[key]) for key in keys[:2])
    rows.append(("all", *(str(total) for total in totals), f"{max(motion[keys[2]]):.2f}"))
    note = f"At full speed the motion takes {motion['motion_s']:.2f} s"
    if motion["time_ratio"] is not None:
        note += f", {motion['time_ratio']:.2f} times the minimum time of the slowest actuator moving alone"
    note += f". Its path is {path['actuator_length_m']:.2f} m long in actuator space"
    if path["length_ratio"] is not None:
        note += f", {path['length_ratio']:.2f} times the straight line"
    header = ("actuator", "sign changes of velocity", "of acceleration", "minimum time, s")
    return Table(header, tuple(rows), words=(0,), note=f"{note}. Values below 5 % of a limit count as zero.")


def rows_table(section: Section) -> Table:
    """Tabulate what a controller makes of the rows by its own interpolation, the worst of all actuators."""
    rows = []
    for method, one in section.items():
        (jumping, jump), usage = next(iter(one["jump"].items())), one["usage"]
        uses = (f"{max(usage[name]):.4f}" if name in usage else "−" for name in ("velocity", "acceleration", "jerk"))
        unit = {"mps": "m/s", "mps2": "m/s²", "mps3": "m/s³"}[jumping.rpartition("_")[2]]
        rows.append((method, f"{1e6 * max(one['deviation_m']):.3f}", *uses, f"{max(jump):.3g} {unit}"))
    header = ("interpolation", "deviation, µm", "of velocity", "of acceleration", "of jerk", "jumps at the rows")
    note = (
        "Parts of the limits between rows; above one, a controller that interpolates so exceeds what the motion keeps"
    )
    return Table(header, tuple(rows), words=(0, 5), note=f"{note}: gantry-tau export --safe slows it down.")


def drives_table(section: Section) -> Table:
    """Tabulate what each drive feels from the drives' part of the summary; without masses, amplification alone."""
    masses, gains = section["reflected_mass_kg"], section["amplification_max"]
    rows = []
    for k, name in enumerate(ACTUATORS):
        felt = ("−", "−") if masses == SKIPPED else (f"{masses[name][side]:.1f}" for side in ("least", "largest"))
        rows.append((name, *felt, *(f"{gains[unit]['by_drive'][k]:.2f}" for unit in ("mm_per_mm", "mrad_per_mm"))))
    header = ("drive", "smallest reflected mass, kg", "largest, kg", "TCP, mm per mm", "mrad per mm")
    return Table(header, tuple(rows), words=(0,), note=_drives_note(section))


def _drives_note(section: Section) -> str:
    if section["reflected_mass_kg"] == SKIPPED:
        return "No masses are given: reflected mass, stiffness and damping are unknown."

    def at(key: str, unit: str, words: str) -> str:
        found = section[key]
        value = true_minus(f"{found['value']:,.0f}")
        return f"{words} {value} {unit}, at {found['t_s']:.2f} s along {mode_words(np.array(found['along']))}."

    return " ".join(
        (
            at("reflected_mass_worst_kg", "kg", "The largest reflected mass in any direction is"),
            at("stiffness_least_npm", "N/m", "The smallest stiffness due to gravity is"),
            at("damping_least_nspm", "Ns/m", "The smallest damping due to the motion is"),
            "For a stable machine the drives have to be stiffer and better damped than negative values ask for.",
        )
    )


def _unit(text: str) -> str:
    return text.replace("^2", "²").replace("^3", "³")


def workspace_part(machine: Machine) -> tuple[Table, Picture]:
    """Tabulate the usable workspace of all working modes without tilt, and draw it."""
    setting = WorkspaceSetting(step_m=step_for(machine, _WORKSPACE_STEP_M, _WORKSPACE_CELLS))
    fine, coarse = at_two_steps(machine, setting)
    table = Table(
        header=tuple(_unit(heading) for heading in WORKSPACE_HEADER),
        rows=tuple(
            (row[0], *(true_minus(cell) for cell in row[1:])) for row in workspace_cells(workspace_rows(fine, coarse))
        ),
        words=(0,),
        note=f"At {greek(setting_text(machine, setting).replace(' deg', '°'))}.",
    )
    return table, workspace_picture(machine, fine)


def bounds_table(config: Config, machine: Machine, bounds: Bounds) -> Table:
    """Tabulate what is proven for every point of the path beside what is allowed; of all pairs only the nearest."""
    rows = []
    # Single values first, then ranges, largest and least values.
    for key in sorted(_stated(bounds), key=lambda key: key.side.value if key.subjects != () else 0):
        cells = _bound_rows(config, machine, bounds, key)
        shown = cells[:1] if _is_of_pairs(key) else cells
        rows += [(key.label.format(subject), *texts) for subject, *texts in shown]
    for name, miss in (("start", bounds.start_miss), ("goal", bounds.goal_miss)):
        rows.append((f"{name} missed by", f"at most {_power(miss)} m or rad", f"at most {_power(END_TOLERANCE)}"))
    return Table(("quantity", "proven for the whole path", "allowed"), tuple(rows), words=(0, 1, 2))


def distances_table(config: Config, machine: Machine, bounds: Bounds) -> Table:
    """Tabulate the proven distances of pairs beside what is allowed: of each kind the nearest, the others counted."""
    rows: list[tuple[str, ...]] = []
    for key in _stated(bounds):
        if _is_of_pairs(key):
            found = _bound_rows(config, machine, bounds, key)
            rows += found[:_NEAREST]
            if others := found[_NEAREST:]:
                rows.append((f"{len(others)} other {'pairs' if len(others) > 1 else 'pair'}", *others[0][1:]))
    return Table(("between", "proven for the whole path", "allowed"), tuple(rows), words=(0, 1, 2))


def _stated(bounds: Bounds) -> list[CertificateKey]:
    return [key for key in certificate_keys() if key.name in bounds.ranges]


def _is_of_pairs(key: CertificateKey) -> bool:
    """Tell whether a key is of pairs, of which there are too many to be listed among others."""
    return key.subjects is None and key.side is Side.LEAST


def _bound_rows(config: Config, machine: Machine, bounds: Bounds, key: CertificateKey) -> list[tuple[str, str, str]]:
    """State subject, bounds and limits of all quantities of a key; if there are many, those with the least first."""
    limits = [quantity for limit in proven_limits(config, machine) for quantity in limit.quantities]
    allowed = {quantity.subject: quantity.allowed for quantity in limits if quantity.key == key}
    ranges = bounds.ranges[key.name]
    order = np.argsort(ranges.values[:, 0]).tolist() if _is_of_pairs(key) else range(len(ranges.subjects))
    rows = [(ranges.subjects[i], ranges.values[i]) for i in order]
    return [(subject, *_bound_texts(key, values.tolist(), allowed[subject])) for subject, values in rows]


def _bound_texts(key: CertificateKey, proven: list[float], allowed: tuple[float, float]) -> tuple[str, str]:
    """State what is proven and what is allowed."""
    if key.side is Side.SIGN:
        return true_minus(f"{proven[0]:+.0f} everywhere"), "never changes"
    unit = key.unit if key.unit in ("", "°") else f" {key.unit}"
    form = {Side.BOTH: "{0} to {1}", Side.LARGEST: "at most {1}"}.get(key.side, "at least {0}")
    texts = ([format(value, spec) for value in pair] for pair, spec in ((proven, f".{key.decimals}f"), (allowed, "g")))
    one, other = (true_minus(form.format(*pair)) + unit for pair in texts)
    return one, "not limited" if np.isinf(allowed).all() else other


def _power(value: float) -> str:
    """Format a very small number as 1.1·10⁻¹¹."""
    mantissa, exponent = f"{value:.1e}".split("e")
    return f"{mantissa}·10{str(int(exponent)).translate(_SUPERSCRIPT)}"


def build_proof(config: Config, refined: PathSamples, profile: KappaProfile) -> Proof:
    """Compare the bound over each box with the sampled kappa, at all samples; the curve to draw is thinned."""
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
