"""The application: its name, its version, and how errors are reported."""

import contextlib
import math
import sys
from collections.abc import Callable, Iterator
from itertools import pairwise
from typing import Annotated, Any, NoReturn

import typer
from rich.markup import escape
from typer.core import TyperCommand, TyperGroup

from pipeline.cli.commands import (
    calibrate,
    certify,
    check,
    correct,
    export,
    init,
    measured,
    report,
    run,
    show,
    simulate,
    simulate_poses,
    tune,
)
from pipeline.cli.commands.analyses import atlas, bound, compare, pose_error, study, tour, tradeoff, workspace
from pipeline.cli.console import discard_output, print_error, print_message
from pipeline.cli.interrupts import ignore_interrupts, was_interrupted
from pipeline.errors import PipelineError, UsageError

_NO_SOLUTION = 1
_USAGE = 2
_INTERRUPTED = 130
_BROKEN_PIPE = 141
_OF_PATHS = ("FILE", "DIR", "RUN")
"""What stands in the help for the values of options that name files or folders."""

_HELP = """Reconfigure a 5-DOF Gantry-Tau from one working mode to another without meeting a singularity.

One YAML file describes the machine and the task. A run turns it into a
route (which regions, which working modes), a path (a smooth curve in
actuator space) and a trajectory (that curve in time, for the controller).

Exit codes: 0 done; 1 no solution, or a route not proven optimal, with the
reason and what to change; 2 bad usage or configuration, with the key;
130 interrupted; 141 nobody reads the output any more.
"""

_BEGIN = (
    "gantry-tau init my-cell    (a configuration with every key explained, to change)",
    "gantry-tau check my-cell/my-cell.yaml    (the machine, and whether it can be at start and goal)",
    "gantry-tau run my-cell/my-cell.yaml    (everything, into results/my-cell)",
    "gantry-tau compare results/my-cell    (the smooth path against the route it came from)",
)


class _Group(TyperGroup):
    """Turns errors meant for users into one message and an exit code; bugs keep their traceback."""

    def main(self, *arguments: Any, **options: Any) -> Any:
        """Run the command line, and report if what it printed last could not be written."""
        try:
            with _errors_reported(leave=sys.exit):
                return super().main(*arguments, **options)
        except SystemExit as ended:
            # Help and usage errors are printed by consoles that end the process themselves.
            if isinstance(ended.__context__, BrokenPipeError):
                sys.exit(_BROKEN_PIPE)
            with _errors_reported(leave=sys.exit):
                sys.stdout.flush()
            raise

    def get_params(self, ctx: Any) -> list[Any]:
        """Give the options of the program; those that take no value show none in the help."""
        return _flags_without_value(super().get_params(ctx))

    def make_context(self, *arguments: Any, **options: Any) -> Any:
        """Parse the options of the program, which may print and end it."""
        with _errors_reported():
            return super().make_context(*arguments, **options)

    def invoke(self, ctx: Any) -> Any:
        """Run a command."""
        with _errors_reported():
            return super().invoke(ctx)


class _Command(TyperCommand):
    """A command that takes no empty text for a path, and no NaN or infinity for a number.

    An empty path would be the working directory; a NaN passes every bound, as all comparisons with it are false.
    """

    def get_params(self, ctx: Any) -> list[Any]:
        """Give the parameters of the command; those that take no value show none in the help."""
        return _flags_without_value(super().get_params(ctx))

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Parse the arguments of the command."""
        options = {name for one in self.params if getattr(one, "metavar", None) in _OF_PATHS for name in one.opts}
        for before, argument in pairwise(["", *args]):
            option = argument.removesuffix("=") if argument else before
            if option in options and (not argument or argument.endswith("=")):
                raise UsageError(f"{option} is empty: give the name of a file or folder, or omit it")
            if not argument and not before.startswith("-"):
                raise UsageError("an argument is empty: give the name of a file or folder")
        rest = super().parse_args(ctx, args)
        parameters: list[Any] = self.params
        for parameter in parameters:
            _require_finite(ctx, parameter)
        return rest


def _flags_without_value(parameters: list[Any]) -> list[Any]:
    for parameter in parameters:
        if getattr(parameter, "is_flag", False):
            parameter.metavar = ""
    return parameters


def _require_finite(ctx: Any, parameter: Any) -> None:
    value = ctx.params.get(parameter.name)
    for number in value if isinstance(value, list | tuple) else (value,):
        if isinstance(number, float) and not math.isfinite(number):
            raise typer.BadParameter(f"{number} is not a finite number", ctx=ctx, param=parameter)


def _leave(code: int) -> NoReturn:
    raise typer.Exit(code) from None


@contextlib.contextmanager
def _errors_reported(leave: Callable[[int], NoReturn] = _leave) -> Iterator[None]:
    """Report errors, and leave with their exit code."""
    try:
        yield
    except PipelineError as error:
        print_error("\n  ".join([str(error), *getattr(error, "__notes__", [])]))
        leave(error.exit_code)
    except KeyboardInterrupt:
        _say_interrupted()
        leave(_INTERRUPTED)
    except OSError as error:
        leave(_report_system_error(error))
    except MemoryError:
        print_error(
            "there is not enough memory.\n"
            "  What to change: lower route.memory_gb to what there is, or coarsen route.grid."
        )
        leave(_NO_SOLUTION)
    except typer.Exit:
        raise
    except Exception:
        # CasADi, for one, takes Ctrl-C within the conversion of an argument for an argument of a wrong type.
        if not was_interrupted():
            raise
        _say_interrupted()
        leave(_INTERRUPTED)


def _say_interrupted() -> None:
    ignore_interrupts()
    print_message("interrupted: nothing is lost, finished stages are kept")


def _report_system_error(error: OSError) -> int:
    """Report an error of the system with its file; return the exit code."""
    file = error.filename2 or error.filename
    if file is None and error.errno is not None:
        # Whatever reads or writes files names them: what cannot be written is output.
        discard_output()
        if isinstance(error, BrokenPipeError):
            return _BROKEN_PIPE
        file = "standard output"
    print_error(f"{file}: {error.strerror}" if file else str(error))
    return _USAGE


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


_GROUPS = (
    init,
    show,
    run,
    certify,
    check,
    compare,
    report,
    export,
    workspace,
    tradeoff,
    atlas,
    bound,
    pose_error,
    study,
    measured,
    simulate_poses,
    calibrate,
    tour,
    correct,
    simulate,
    tune,
)
for _group in _GROUPS:
    for _command, _examples in _group.COMMANDS:
        app.command(cls=_Command, epilog=_epilog(_examples))(_command)
