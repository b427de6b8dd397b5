"""The command that proves a path, or verifies a certificate again."""

import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from pipeline.cli.console import results_console
from pipeline.cli.options import ForceOption, OutOption, UnprovenOption, VerboseOption, load_task, specs_of
from pipeline.cli.output import text_table
from pipeline.cli.run_stages import run_stages
from pipeline.errors import NoSolutionError, UsageError
from pipeline.regular_file import open_regular_file
from pipeline.stage import Stage

if TYPE_CHECKING:
    from pipeline.certify.recheck import Claim, Statement
    from pipeline.certify.recheck.time_law import StatedMotion
    from pipeline.run.results import Results

_NAMED = 5
"""Claims that an error names."""


def certify(
    context: typer.Context,
    config: Annotated[
        Path | None,
        typer.Argument(metavar="CONFIG", help="The YAML file with machine, task and options; or a run, --calibration."),
    ] = None,
    out: OutOption = None,
    force: ForceOption = False,
    verbose: VerboseOption = False,
    unproven: UnprovenOption = False,
    tolerance: Annotated[
        bool,
        typer.Option("--tolerance", help="Also search the calibration errors the path is proven to bear."),
    ] = False,
    following: Annotated[
        bool,
        typer.Option(
            "--following",
            help="Also search by how much drives may be off: within limits, and on the branch; and these tolerances.",
        ),
    ] = False,
    calibration: Annotated[
        Path | None,
        typer.Option(
            "--calibration", metavar="FILE", help="Prove a finished run for every machine that a calibration allows."
        ),
    ] = None,
    sigma: Annotated[
        float | None,
        typer.Option(
            "--sigma", metavar="K", min=1e-3, max=1e3, help="Standard deviations of every combination. Default: 3."
        ),
    ] = None,
    probability: Annotated[
        float | None,
        typer.Option(
            "--probability", metavar="P", min=1e-6, max=1.0 - 1e-12, help="Of all parameters together, for K."
        ),
    ] = None,
    check: Annotated[
        Path | None,
        typer.Option("--check", metavar="FILE", help="Verify a certificate, or that of a run, again; prove nothing."),
    ] = None,
) -> None:
    """Prove that the whole path is one motion free of singularities, and within its limits.

    Runs stages one and two first, unless their results in DIR are up to
    date. With --check, a certificate is verified again by other code in other
    arithmetic; the run's config.yaml and path.npz must be beside it.
    Tolerances once found are kept as long as the path is; with
    certify.what: tolerances (or following) in CONFIG every run searches them.

    --calibration adds to the certificate of a run, planned with a calibrated
    machine, the proof for every machine within K standard deviations of it:
    of every combination of its parameters, so that all of them together are
    within with the probability that is shown. FILE is what calibrate wrote
    beside its --output. Exits with 1 if even the branch is not proven.
    """
    others = config is not None or out is not None or force or tolerance or following or unproven
    if check is not None:
        if others or any(one is not None for one in (calibration, sigma, probability)):
            raise UsageError("--check FILE excludes other options: the configuration is the one beside the certificate")
        verify_file(check)
        return
    if config is None:
        raise UsageError("certify needs a CONFIG, or --check FILE")
    if calibration is not None:
        if out is not None or force or tolerance or following or unproven or None not in (sigma, probability):
            raise UsageError("--calibration goes with a run folder, and with --sigma or --probability alone")
        certify_machines(config, calibration, sigma, probability)
        return
    if sigma is not None or probability is not None:
        raise UsageError("--sigma and --probability go with --calibration FILE")
    from pipeline.config.choices import Proof
    from pipeline.run import RunOptions

    proof = Proof.FOLLOWING if following else Proof.TOLERANCES if tolerance else None
    options = RunOptions(last=Stage.CERTIFY, force=force, verbose=verbose, unproven=unproven, proof=proof)
    run_stages(config, load_task(config), out, options, specs_of(context))


def certify_machines(folder: Path, file: Path, sigma: float | None, probability: float | None) -> None:
    """Prove a run for every machine that a calibration leaves possible, and show what was proven.

    Raises
    ------
    UsageError
        When the run or the calibration cannot be read, or the machine of the run is not the calibrated one.
    NoSolutionError
        When not even the branch is proven.
    """
    from pipeline.calibrate.stored import read_calibration
    from pipeline.cli.console import messages_console
    from pipeline.cli.reporter import make_reporter
    from pipeline.progress import Monitor
    from pipeline.run.added.calibrated import Wanted, certify_calibrated
    from pipeline.summary.certificate import proof_words

    stored = read_calibration(file)
    wanted = Wanted(sigma if sigma is not None or probability is not None else 3.0, probability)
    with make_reporter(messages_console(), verbose=False) as reporter:
        monitor, began = Monitor(reporter.begin(Stage.CERTIFY)), time.perf_counter()
        try:
            added = certify_calibrated(folder, stored, wanted, monitor)
        except NoSolutionError:
            reporter.end(Stage.CERTIFY, "failed", time.perf_counter() - began)
            raise
        reporter.end(Stage.CERTIFY, "done", time.perf_counter() - began)
    broken = added.proof.broken
    results_console().print(
        proof_words(added.stated, None if broken is None else f"s = {broken.s:.4f}: {broken.reason.text}"),
        soft_wrap=True,
    )


def verify_file(file: Path) -> None:
    """Verify a certificate, or that of a run folder, with the path and the configuration beside it.

    Raises
    ------
    UsageError
        When the certificate, its path or its configuration cannot be read.
    NoSolutionError
        When a claim is not verified; the table shows every claim.
    """
    from pipeline.artifacts.files import MOST_BYTES
    from pipeline.artifacts.layout import CERTIFICATE_JSON, TRAJECTORY_NPZ
    from pipeline.artifacts.results.certificate.stored import read_certificate
    from pipeline.artifacts.results.following import table_claims
    from pipeline.certify.recheck import verify
    from pipeline.route.regions.endpoints import task_endpoints

    file = file / CERTIFICATE_JSON if file.is_dir() else file
    try:
        open_regular_file(file, MOST_BYTES).close()
    except FileNotFoundError:
        raise UsageError(f"{file} does not exist.\n  What to change: give the certificate.json of a run.") from None
    # A certificate may be 180 MB: what is missing beside it is said before it is read.
    results = _run_beside(file)
    config, machine, path = results.config, results.machine, results.refinement.path
    stated = read_certificate(file)
    began = time.perf_counter()
    claims = verify(config, machine, path, task_endpoints(config, machine), stated)
    claims += _pose_error_claims(results)
    trajectory = results.trajectory if (results.folder / TRAJECTORY_NPZ).exists() else None
    claims += table_claims(file.parent, stated.chains, trajectory)
    claims += _motion_claims(results)
    claims += _machines_claims(results, stated)
    seconds = time.perf_counter() - began
    # What fails comes last: it is what a reader has to see.
    in_order = sorted(claims, key=lambda claim: not claim.verified)
    rows = [(claim.what, "yes" if claim.verified else "NO", claim.found) for claim in in_order]
    header = ("claim", "verified", "found")
    results_console().print(text_table(f"{file}: verified again in {seconds:.2f} s", header, rows, (0, 1, 2)))
    if wrong := [f"{claim.what} ({claim.found})" for claim in claims if not claim.verified]:
        more = f"; and {len(wrong) - _NAMED} more, at the end of the table" if len(wrong) > _NAMED else ""
        raise NoSolutionError(
            Stage.CERTIFY,
            f"{file} does not hold, {len(wrong)} of {len(claims)} claims: {'; '.join(wrong[:_NAMED])}{more}",
            "make it again: gantry-tau run CONFIG --from certify --force",
        )


def _pose_error_claims(results: "Results") -> "list[Claim]":
    """Verify what the run states of its tool's error, if it was asked for."""
    from pipeline.artifacts.results.pose_error import (
        amplification_claim,
        load_pose_error,
        stated_error,
        uncertainty_of,
    )
    from pipeline.certify.recheck import Claim
    from pipeline.certify.recheck.pose_error import verify_pose_error

    asked = results.config.certify.pose_error
    if asked is None:
        return []
    try:
        stated = stated_error(results.folder)
    except FileNotFoundError as error:
        found = f"{Path(str(error.filename)).name} is missing; prove it again: gantry-tau certify CONFIG --force"
        return [Claim("tool: its error is proven", verified=False, found=found)]
    claims = verify_pose_error(results.machine, results.refinement.path, stated, uncertainty_of(asked))
    table = load_pose_error(results)
    return claims if table is None else [*claims, amplification_claim(results.refinement.path, stated.chain, table)]


def _machines_claims(results: "Results", stated: "Statement") -> "list[Claim]":
    """Verify that machines which a calibration leaves possible are those of its file, which the run keeps."""
    from pipeline.artifacts.layout import CALIBRATION_JSON
    from pipeline.calibrate.recheck import machines_claims

    if stated.machines is None:
        return []
    return machines_claims(results.folder / CALIBRATION_JSON, results.config.machine, results.refinement.path, stated)


def _motion_claims(results: "Results") -> "list[Claim]":
    """Verify what the run states of its motion and of the way back, as far as it has any."""
    from pipeline.artifacts.results.proven_motion import stated_motions

    return [
        claim for name, stated in stated_motions(results.folder).items() for claim in _claims(results, name, stated)
    ]


def _claims(results: "Results", name: str, stated: "StatedMotion | None") -> "list[Claim]":
    """Verify what is stated of a motion; where nothing is, or where it cannot be computed, a claim says so."""
    from dataclasses import replace

    from pipeline.artifacts.layout import TRAJECTORY_NPZ
    from pipeline.certify.recheck import Claim
    from pipeline.certify.recheck.loads import verify_loads
    from pipeline.certify.recheck.time_law import verify_time_law
    from pipeline.retime import law_sha256, way_back

    def unproven(why: str) -> list[Claim]:
        found = f"{why}; time the path again: gantry-tau retime CONFIG --force"
        return [Claim(f"{name}: the motion is proven", verified=False, found=found)]

    if stated is None:
        return unproven("nothing is stated of it")
    if not (results.folder / TRAJECTORY_NPZ).exists():
        return unproven(f"{TRAJECTORY_NPZ} is missing")
    motion = results.trajectory
    try:
        motion = motion if name == "trajectory" else way_back(results.config, motion)
    except NoSolutionError as error:
        return unproven(error.reason)
    jerk = results.config.retime.jerk
    claims = [
        *verify_time_law(motion.path, motion.time_law, law_sha256(motion), stated, jerk=jerk),
        *verify_loads(motion.path, motion.time_law, stated),
    ]
    return [replace(claim, what=f"{name}: {claim.what}") for claim in claims]


def _run_beside(file: Path) -> "Results":
    from pipeline.run.reading import open_results

    try:
        return open_results(file.parent)
    except UsageError as error:
        raise UsageError(f"{file} cannot be verified without its run: {error}") from None


COMMANDS: tuple[tuple[Callable[..., None], tuple[str, ...]], ...] = (
    (
        certify,
        (
            "gantry-tau certify configs/agder.yaml",
            "gantry-tau certify configs/agder.yaml --tolerance    (a minute more)",
            "gantry-tau certify configs/agder.yaml --following    (another minute)",
            "gantry-tau certify results/real --calibration real.json --sigma 3",
            "gantry-tau certify --check results/agder/certificate.json",
        ),
    ),
)
"""Every command with its examples."""
