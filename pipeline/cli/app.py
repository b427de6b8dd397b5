"""The application: its name, its version, and how errors are reported."""

import os
import signal
import sys
from types import FrameType
from typing import Annotated, Any, NoReturn

import typer
from rich.markup import escape
from typer.core import TyperGroup

from pipeline.cli.commands import certify, check, compare, export, measured, report, run, workspace
from pipeline.cli.console import messages_console, print_error
from pipeline.errors import PipelineError

_USAGE = 2
_INTERRUPTED = 130
_BROKEN_PIPE = 141

_HELP = """Reconfigure a 5-DOF Gantry-Tau from one working mode to another without meeting a singularity.

One YAML file describes the machine and the task. A run turns it into a
route (which regions, which working modes), a path (a smooth curve in
actuator space) and a trajectory (that curve in time, for the controller).

Exit codes: 0 done; 1 no solution, with the reason and what to change;
2 bad usage or configuration; 130 interrupted.
"""

_BEGIN = (
    "gantry-tau check configs/agder.yaml    (the machine, and whether it can be at start and goal)",
    "gantry-tau run configs/agder.yaml    (everything, into results/agder)",
    "gantry-tau compare results/agder    (the smooth path against the route it came from)",
)


class _Interrupt(KeyboardInterrupt):
    """Ctrl-C, as a class of its own.

    CPython remembers if a plain KeyboardInterrupt leaves code that was given as text (a dataclass created while a
    module is imported), and then ends the process by the signal, even if the exception was handled.
    """


class _Group(TyperGroup):
    """Turns errors meant for users into one message and an exit code; bugs keep their traceback."""

    def invoke(self, ctx: Any) -> Any:
        """Run a command."""
        try:
            return super().invoke(ctx)
        except PipelineError as error:
            print_error("\n  ".join([str(error), *getattr(error, "__notes__", [])]))
            raise typer.Exit(error.exit_code) from None
        except KeyboardInterrupt:
            messages_console().print("interrupted: nothing is lost, finished stages are kept")
            raise typer.Exit(_INTERRUPTED) from None
        except BrokenPipeError:
            _stop_writing()
            raise typer.Exit(_BROKEN_PIPE) from None
        except OSError as error:
            # Files are written under temporary names and then renamed: the second name is the one the user knows.
            file = error.filename2 or error.filename
            print_error(f"{file}: {error.strerror}" if file else str(error))
            raise typer.Exit(_USAGE) from None


def _epilog(examples: tuple[str, ...]) -> str:
    # Only paragraphs start on a new line.
    return "\n\n".join(("[bold]Examples[/bold]", *(escape(example) for example in examples)))


app = typer.Typer(
    name="gantry-tau",
    cls=_Group,
    help=_HELP,
    epilog=_epilog(_BEGIN),
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode="rich",
    pretty_exceptions_enable=False,
)


def _show_version(wanted: bool) -> None:
    if wanted:
        from pipeline.summary.versions import PACKAGE, package_version

        typer.echo(f"{PACKAGE} {package_version()}")
        raise typer.Exit


@app.callback()
def _root(
    version: Annotated[
        bool, typer.Option("--version", callback=_show_version, is_eager=True, help="Show the version and exit.")
    ] = False,
) -> None:
    pass


for _group in (run, certify, check, compare, report, export, workspace, measured):
    for _command, _examples in _group.COMMANDS:
        app.command(epilog=_epilog(_examples))(_command)


def main() -> None:
    """Run the command line of this process."""
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _interrupt)
    app()


def _interrupt(_signal: int, _frame: FrameType | None) -> NoReturn:
    raise _Interrupt


def _stop_writing() -> None:
    """Discard further output: the reader is gone, and Python would complain at exit."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, sys.stdout.fileno())
