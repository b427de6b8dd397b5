"""The benchmark as a Markdown page."""

from collections.abc import Iterable, Sequence
from typing import Any

from tests.benchmarks.isolated import FINISHED
from tests.benchmarks.side_by_side import METHODS

_PARTS = {"regions_s": "region table", "moves_s": "moves", "relaxation_s": "relaxation", "solve_s": "core and solve"}


def markdown(results: dict[str, Any]) -> str:
    """Write all results as one page."""
    sections = [
        "# Benchmark of stage one",
        "Written by `make bench`; every number is in `route.json`. Seconds are wall-clock, each measurement in a "
        "process of its own, peak memory is that of the whole process.",
        _host(results["host"]),
    ]
    if results["cases"]:
        sections += ["## The reference task on finer grids", *_cases(results["cases"])]
    if results["growth"]:
        sections += ["## Growth", *_growth(results["growth"])]
    if results["instances"]:
        sections += ["## Side by side", *_side_by_side(results)]
    if results["resolution"]["reference"]:
        sections += ["## Resolution", *_resolution(results["resolution"])]
    return "\n\n".join(sections) + "\n"


def _host(host: dict[str, Any]) -> str:
    versions = ", ".join(f"{name} {version}" for name, version in host["versions"].items())
    rows = [
        ("CPU", f"{host['cpu']}, {host['cores']} cores"),
        ("memory", f"{host['memory_gb']:.1f} GB"),
        ("system", host["system"]),
        ("versions", versions),
        ("date", f"{host['date']}, load {host['load_before']:.2f} before the start"),
    ]
    return table(("", "measured on"), rows)


def _cases(cases: Sequence[dict[str, Any]]) -> list[str]:
    size = table(
        ("grid", "regions", "gates", "moves", "N", "nominal variables", "core regions", "core columns", "peak MB"),
        [
            (
                case["name"],
                *(_count(case, key) for key in ("regions", "gates", "moves", "step_budget", "nominal_variables")),
                *(_count(case, key) for key in ("core_regions", "core_columns", "peak_mb")),
            )
            for case in cases
        ],
    )
    seconds = table(
        ("grid", "region table s", "times SVD", "moves s", "relaxation s", "core and solve s", "total s", "followed s"),
        [
            (
                case["name"],
                _seconds(case, "regions_s"),
                f"{case['regions_s'] / case['svd_s']:.1f}" if "svd_s" in case else "-",
                *(_seconds(case, key) for key in ("moves_s", "relaxation_s", "solve_s", "total_s", "followed_s")),
            )
            for case in cases
        ],
    )
    optimum = table(
        ("grid", "optimum", "threshold", "gap", "with moves followed", "rounds", "how it ended"),
        [
            (
                case["name"],
                _cost(case, "objective"),
                _cost(case, "threshold"),
                f"{case['gap']:.1%}" if "gap" in case else "-",
                "none" if "not_followed" in case else _cost(case, "followed_objective"),
                _count(case, "rounds"),
                case.get("status", "-") if case["ended"] == FINISHED else case["ended"],
            )
            for case in cases
        ],
    )
    return [
        size,
        seconds,
        "*Times SVD*: the region table's seconds in those that `np.linalg.svd` alone takes on the matrices of its "
        "regions, the limit for any table with true condition numbers. *Total* is the sum of the four parts. "
        "*Followed* is the region table and the whole of stage one as `gantry-tau route` does it: every move of the "
        "route followed continuously, and solved again without those that fail.",
        optimum,
    ]


def _growth(growth: dict[str, Any]) -> list[str]:
    names = _PARTS | {"total_s": "total"}
    regions = next(iter(growth.values()))["regions"]
    rows = []
    for part, fit in growth.items():
        ratios = dict(zip(fit["regions"], fit["n_log_n"], strict=True))
        cells = [f"{ratios[n]:.2f}" if n in ratios else "-" for n in regions]
        rows.append((names[part], f"{fit['exponent']:.2f}", *cells))
    return [
        "Exponent e of seconds ~ n^e, n the regions; then seconds over n log n, as multiples of the smallest grid's: "
        "below 1 the cost grows more slowly than n log n.",
        table(("part", "e", *(f"n = {n:,.0f}" for n in regions)), rows),
    ]


def _side_by_side(results: dict[str, Any]) -> list[str]:
    limit = results["settings"]["peer_limit_s"]
    rows = [
        (
            instance["name"],
            _count(instance, "regions"),
            _count(instance, "moves"),
            _count(instance, "step_budget"),
            _cost(instance, "optimum"),
            *(
                _result(instance["methods"].get(method.name, {"status": instance.get("ended", "-")}))
                for method in METHODS
            ),
            "yes" if instance.get("agree") else "NO",
        )
        for instance in results["instances"]
    ]
    head = ("problem", "regions", "moves", "N", "optimum", *(method.name for method in METHODS), "agree")
    return [
        f"Telescopes of any length, carts on their rails, N a few above the fewest positions; {limit:g} s for every "
        "solver. Seconds: for the peers those of the solver alone, without building its program; for the core and "
        "Dijkstra moves and shortest paths, too. *Detour*: from x 1.4 to 0.6, so that x binds. *Agree*: all that "
        "claim an optimum have the same within 1e-6, by a route that keeps every rule. CP-SAT works in millionths of "
        "kappa and of a step and uses all cores; the others work in floating point, on one.",
        table(head, rows),
        _headline(results["headline"]),
    ]


def _headline(headline: dict[str, Any] | None) -> str:
    if headline is None:
        return "No peer solved any of these problems within the limit."
    return (
        f"The largest problem that any peer solves is {headline['problem']} ({headline['regions']:,} regions): the "
        f"best of them, {headline['best_peer']}, takes {headline['best_peer_s']:.2f} s, the core "
        f"{headline['core_s']:.3f} s: **{headline['ratio']:.0f} times** faster. (Dijkstra is no peer: it leaves out x "
        "and the step budget, and the core begins with it.)"
    )


def _resolution(study: dict[str, Any]) -> list[str]:
    counts = ("regions", "moves")
    reference = [
        (c["name"], *(_count(c, k) for k in counts), *(_kappa(c, k) for k in ("relaxation", "scaled", "bottleneck")))
        for c in study["reference"]
    ]
    level = [(c["name"], *(_count(c, k) for k in counts), _kappa(c, "bottleneck")) for c in study["level"]]
    exponents = ["-" if study[key] is None else f"{study[key]:.2f}" for key in ("reference_exponent", "level_exponent")]
    return [
        "The reference task, x and the step budget left out. *Sum times step* is in steps of 0.1 m, so that it "
        "compares between grids; *least largest kappa* is that of the best route for it.",
        table(("grid", "regions", "moves", "least sum of kappa", "sum times step", "least largest kappa"), reference),
        "The 3-DOF machine, both tilts locked, on moves that (14)-(17) and (38) alone admit: no limit on kappa, no "
        "clearance, any sign of det H. Its ways lead over singularities, which a grid jumps over.",
        table(("grid", "regions", "moves", "least largest kappa"), level),
        f"Least largest kappa ~ step^-e: e = {exponents[0]} with tilt, e = {exponents[1]} without. Near zero there is "
        "a way that does not depend on the grid; near one, kappa grows without bound as the grid gets finer: evidence, "
        "not proof, that there is no way at any resolution.",
    ]


def _kappa(figures: dict[str, Any], key: str) -> str:
    return f"{figures[key]:.2f}" if key in figures else "-"


def _result(result: dict[str, Any]) -> str:
    if result["status"] in ("optimal", "infeasible"):
        note = "" if result["status"] == "optimal" else " (none)"
        return f"{_seconds(result, 'seconds')}{note}"
    if result["status"] != "time limit":
        return str(result["status"])
    best = f"best {result['objective']:.2f}" if "objective" in result else "no route"
    bound = result.get("bound")
    return f"not solved: {best}" + (f", bound {bound:.2f}" if bound is not None and abs(bound) < 1e9 else "")


def _count(figures: dict[str, Any], key: str) -> str:
    return f"{figures[key]:,.0f}" if key in figures else "-"


def _cost(figures: dict[str, Any], key: str) -> str:
    return f"{figures[key]:.6f}" if figures.get(key) is not None else "-"


def _seconds(figures: dict[str, Any], key: str) -> str:
    if key not in figures:
        return "-"
    value = figures[key]
    return f"{value:.3f}" if value < 1 else f"{value:.2f}" if value < 10 else f"{value:.1f}"


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Write a Markdown table."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)
