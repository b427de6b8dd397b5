"""The report of a run folder, from whatever results there are."""

from pathlib import Path

from pipeline.artifacts import State, open_run_folder, read_run_folder, write_whole
from pipeline.artifacts.layout import REPORT, failure_report
from pipeline.artifacts.output import write_output
from pipeline.errors import UsageError
from pipeline.machine.geometry import build_machine
from pipeline.run.reading import refuse_damage
from pipeline.run.results import Results
from pipeline.run.stage_specs import SPECS, Specs, report_of
from pipeline.stage import Stage


def write_report(folder: Path, output: Path | None = None, specs: Specs = SPECS) -> Path:
    """Write the report of a run, complete or not, into its folder or elsewhere; return where it is.

    In the folder of a run that failed, it goes to the details of the failure.

    Raises
    ------
    UsageError
        When the folder is not a run folder, a run is writing to it, or its results are damaged or of another version.
    """
    config, _ = read_run_folder(folder)
    with open_run_folder(folder, [pattern for spec in specs for pattern in spec.patterns]) as opened:
        for stage, record in opened.state.stages.items():
            # Figures are not part of the report, and may have been removed.
            if stage is not Stage.FIGURES:
                refuse_damage(folder, record)
        results = Results(config, build_machine(config.machine), folder, specs)
        try:
            page = report_of(specs)(results, opened.state)
        except KeyError as error:
            raise _of_another_version(folder, f"the summary has no {error}") from None
        except (TypeError, ValueError, AttributeError, IndexError) as error:
            # Only what was sealed is known to be what this program wrote.
            if all(record.fingerprint for record in opened.state.stages.values()):
                raise
            raise _of_another_version(folder, f"the summary cannot be read ({error})") from None
        if output is not None:
            write_output(output, page)
            return output
        target = folder / _name(opened.state)
        write_whole(target, page)
        return target


def _of_another_version(folder: Path, why: str) -> UsageError:
    return UsageError(f"{folder} was written by another version: {why}.\n  What to change: run the pipeline again.")


def _name(state: State) -> str:
    failed = [stage for stage, record in state.stages.items() if record.status == "failed"]
    return failure_report(failed[0]) if failed else REPORT
