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
    from pipeline.certify.recheck import Claim
    from pipeline.certify.recheck.time_law import StatedMotion
    from pipeline.run.results import Results

_NAMED = 5
"""Claims that an error names."""


def certify(
    context: typer.Context,
    config: Annotated[
        Path | None, typer.Argument(metavar="CONFIG", help="The YAML file with machine, task and options.")
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
    """
    if check is not None:
        if config is not None or out is not None or force or tolerance or following or unproven:
            raise UsageError("--check FILE excludes other options: the configuration is the one beside the certificate")
        verify_file(check)
        return
    if config is None:
        raise UsageError("certify needs a CONFIG, or --check FILE")
    from pipeline.config.choices import Proof
    from pipeline.run import RunOptions

    proof = Proof.FOLLOWING if following else Proof.TOLERANCES if tolerance else None
    options = RunOptions(last=Stage.CERTIFY, force=force, verbose=verbose, unproven=unproven, proof=proof)
    run_stages(config, load_task(config), out, options, specs_of(context))


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
            "gantry-tau certify --check results/agder/certificate.json",
        ),
    ),
)
"""Every command with its examples."""
