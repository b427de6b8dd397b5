"""The commands with their arguments and options, as Typer knows them."""

import re
from enum import Enum
from typing import Any

import typer

from from_code.markdown import literal, plain, table
from pipeline.cli.application import app

_MARKUP = re.compile(r"\[/?bold\]")


def command_reference() -> str:
    """Write a section for every command, in the order of `--help`."""
    commands: dict[str, Any] = typer.main.get_command(app).commands  # type: ignore[attr-defined]
    return "\n".join(_command(name, command) for name, command in commands.items())


def _command(name: str, command: Any) -> str:
    arguments = [one for one in command.params if one.param_type_name == "argument"]
    options = [one for one in command.params if one.param_type_name == "option"]
    usage = " ".join(["gantry-tau", name, *map(_usage, arguments), "[OPTIONS]"])
    rows = [(literal(_name(one)), plain(one.help or ""), "") for one in arguments]
    rows += [(_option(one), plain(one.help or ""), _default(one)) for one in options]
    text = f"## {name}\n\n{plain(command.help or '')}\n\n```text\n{usage}\n```\n\n"
    text += table(("argument, option", "meaning", "default"), rows)
    return text + _examples(command.epilog or "")


def _name(argument: Any) -> str:
    """Name an argument without the brackets of one that may be left out."""
    return str(argument.metavar or argument.name.upper()).strip("[]")


def _usage(argument: Any) -> str:
    name = _name(argument)
    name = f"{name} ..." if argument.nargs == -1 else name
    return name if argument.required else f"[{name}]"


def _option(option: Any) -> str:
    kind = option.type_descriptor.annotation
    names = ", ".join(literal(name) for name in sorted(option.opts, key=len, reverse=True))
    if option.is_flag:
        return names
    if isinstance(kind, type) and issubclass(kind, Enum):
        return f"{names} " + " \\| ".join(literal(choice.value) for choice in kind)
    return f"{names} {plain(option.metavar or '')}"


def _default(option: Any) -> str:
    value = option.default
    if option.is_flag or value is None or callable(value):
        return ""
    value = value.value if isinstance(value, Enum) else value
    return literal(" ".join(map(str, value)) if isinstance(value, list | tuple) else value)


def _examples(epilog: str) -> str:
    """Write the examples of the help text: commands as code, what is said of one behind it as its comment."""
    lines = [line for line in _MARKUP.sub("", epilog).replace("\\[", "[").split("\n\n") if line.strip()][1:]
    return "\nExamples:\n\n```text\n" + "\n".join(lines) + "\n```\n" if lines else ""
