"""What a stage makes."""

from dataclasses import dataclass, field

from pipeline.summary.section import Section


@dataclass(frozen=True, eq=False)
class Product:
    """The files of a stage by name, its part of the summary, and files of earlier stages that it completes."""

    files: dict[str, bytes] = field(default_factory=dict)
    section: Section = field(default_factory=dict)
    completed: dict[str, bytes] = field(default_factory=dict)
