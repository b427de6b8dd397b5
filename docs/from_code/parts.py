"""The parts of pages that are generated, by the names that stand for them."""

import re
from collections.abc import Callable

from from_code.command_line import command_reference
from from_code.configuration import configuration_reference, configuration_yaml, study_reference
from from_code.design import design_table
from from_code.files import benchmark_pages, figure_list, trajectory_columns
from from_code.four_dof import four_dof_table
from from_code.notebooks import notebook_page
from from_code.python_interface import python_reference
from from_code.reference_run import reference_run

PARTS: dict[str, Callable[..., str]] = {
    "benchmarks": benchmark_pages,
    "commands": command_reference,
    "configuration keys": configuration_reference,
    "configuration yaml": configuration_yaml,
    "design": design_table,
    "figures": figure_list,
    "four dof": four_dof_table,
    "notebook": notebook_page,
    "python interface": python_reference,
    "reference run": reference_run,
    "study keys": study_reference,
    "trajectory columns": trajectory_columns,
}
_MARK = re.compile(r"^<!-- from code: ([a-z ]+?)(?: \[(\S+)\])? -->$", re.MULTILINE)


def fill_in(text: str) -> str:
    """Replace every mark in a page, `<!-- from code: NAME -->` or with an argument `[ARGUMENT]`, by what it stands for.

    Raises
    ------
    KeyError
        When there is no such part.
    """
    return _MARK.sub(lambda mark: PARTS[mark[1]](*filter(None, mark.groups()[1:])), text)
