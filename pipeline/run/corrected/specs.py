"""The stages of a run that corrects the path of another one: no regions and no route; proof and time as of any path."""

from dataclasses import replace
from typing import TYPE_CHECKING, Any

from pipeline.artifacts.layout import CORRECTION_CSV, PATH_CSV
from pipeline.config import Config
from pipeline.config.file import config_sha256
from pipeline.run.config_parts import refine_part
from pipeline.run.stage_specs import SPECS, Deferred, Specs
from pipeline.stage import Stage

if TYPE_CHECKING:
    from pipeline.run.corrected.maker import Planned

_NEXT = "gantry-tau export {folder}, and the report with gantry-tau report {folder}"


def corrected_specs(planned: "Planned") -> Specs:
    """Give the rows of all stages, with a path that is corrected from a planned one."""
    from pipeline.certify import path_sha256

    facts = {"path": path_sha256(planned.refinement.path), "machine": config_sha256(planned.machine)}

    def part(config: Config) -> dict[str, Any]:
        # How the machine would be driven uncorrected depends on zeros and scales of both machines.
        actuators = config.machine.actuators.model_dump(mode="json")
        return {**refine_part(config), "actuators": actuators, "planned": facts}

    rows = {
        Stage.REFINE: {
            "upstream": (),
            "config_part": part,
            "make": Deferred("pipeline.run.corrected.maker", "make_corrected"),
            "words": Deferred("pipeline.run.corrected.maker", "corrected_words"),
            "shown": ((PATH_CSV, "the corrected path, densely sampled"), (CORRECTION_CSV, "the correction over s")),
            "next_step": _NEXT,
        },
        Stage.RETIME: {"next_step": _NEXT},
    }
    return tuple(replace(spec, **rows.get(spec.stage, {})) for spec in SPECS)  # type: ignore[arg-type]
