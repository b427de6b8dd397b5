"""A certificate verified again on the command line: its claims as a table, an error when one does not hold."""

import time
from pathlib import Path

from rich.console import Console
from rich.table import Table

from pipeline.errors import NoSolutionError


def verify_file(file: Path, console: Console) -> None:
    """Verify a certificate, or that of a run folder, beside the path and the configuration it speaks of.

    Raises
    ------
    UsageError
        When the certificate, its path or its configuration cannot be read.
    NoSolutionError
        When a claim is not verified; every one is in the table.
    """
    from pipeline.artifacts.certificate import read_certificate
    from pipeline.artifacts.layout import CERTIFICATE_JSON
    from pipeline.artifacts.results import load_refinement
    from pipeline.certify.recheck import verify
    from pipeline.route.regions.endpoints import task_endpoints
    from pipeline.run.reading import open_results
    from pipeline.stage import Stage

    file = file / CERTIFICATE_JSON if file.is_dir() else file
    stated = read_certificate(file)
    results = open_results(file.parent)
    config, machine = results.config, results.machine
    path = load_refinement(file.parent, machine).path
    began = time.perf_counter()
    claims = verify(config, machine, path, task_endpoints(config, machine), stated)
    seconds = time.perf_counter() - began
    table = Table(title=f"{file}: verified again in {seconds:.2f} s", title_justify="left")
    for heading in ("claim", "verified", "found"):
        table.add_column(heading)
    for claim in claims:
        table.add_row(claim.what, "yes" if claim.verified else "NO", claim.found)
    console.print(table)
    if wrong := [claim.what for claim in claims if not claim.verified]:
        raise NoSolutionError(
            Stage.CERTIFY,
            f"{file} does not hold: {wrong[0]}",
            "certify the path again: gantry-tau certify CONFIG --force",
        )
