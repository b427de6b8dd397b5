"""Ways to call the command line, and to change what it is given."""

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import yaml
from typer.testing import CliRunner, Result

from pipeline.cli import app
from pipeline.run.stage_specs import SPECS, Specs

Call = Callable[..., Result]
ESCAPE = "\x1b"


def invoke(*arguments: object, specs: Specs = SPECS) -> Result:
    """Call the command line in this process; bugs are raised."""
    result = CliRunner().invoke(app, [str(argument) for argument in arguments], obj=specs)
    if result.exception is not None and not isinstance(result.exception, SystemExit):
        raise result.exception
    return result


def edit(path: Path, **changes: Any) -> Path:
    """Change keys of a YAML file without asking whether they are allowed."""
    data = yaml.safe_load(path.read_text())
    for name, value in changes.items():
        *sections, key = name.split("__")
        part = data
        for section in sections:
            part = part[int(section) if section.isdecimal() else section]
        part[key] = value
    path.write_text(yaml.safe_dump(data))
    return path


def subprocess_env() -> dict[str, str]:
    """Environment for a process of its own, with few threads."""
    return {**os.environ, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
