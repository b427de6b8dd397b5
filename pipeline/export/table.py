"""Tables as users want them: units, names of the columns, separator and decimal mark."""

from collections.abc import Mapping

from pipeline.errors import UsageError
from pipeline.export.csv import Column, format_csv
from pipeline.export.formats import DecimalMark
from pipeline.export.request import ExportOptions
from pipeline.export.units import converted


def format_table(columns: Mapping[str, Column], decimals: int, options: ExportOptions) -> str:
    """Write columns in SI units as a table in the units and under the names asked for.

    Raises
    ------
    UsageError
        When there are more or fewer names than columns, or a name is empty or given twice.
    """
    table = converted(columns, options.length, options.angle)
    if options.names is not None:
        table = dict(zip(_checked(options.names, tuple(table)), table.values(), strict=True))
    comma = options.decimal is DecimalMark.COMMA
    return format_csv(table, decimals, options.separator.character, decimal_comma=comma)


def _checked(names: tuple[str, ...], columns: tuple[str, ...]) -> tuple[str, ...]:
    if len(names) != len(columns):
        raise UsageError(f"--names gives {len(names)} names for {len(columns)} columns: {', '.join(columns)}")
    if not all(names) or len(set(names)) < len(names):
        raise UsageError(f"--names has to name every column once: {', '.join(names)}")
    return names
