"""The stages of a run that corrects the path of another one: no regions and no route; proof and time as of any path."""

from dataclasses import replace
from typing import TYPE_CHECKING, Any

from pipeline.artifacts.layout import CORRECTION_CSV, PATH_CSV
from pipeline.config import Config
from pipeline.config.file import config_sha256
from pipeline.run.config_parts import refine_part
from pipeline.run.stage_specs import SPECS, Deferred, Specs, StageSpec
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

    def changed(spec: StageSpec) -> StageSpec:
        if spec.stage is Stage.REFINE:
            return replace(
                spec,
                upstream=(),
                config_part=part,
                make=Deferred("pipeline.run.corrected.maker", "make_corrected"),
                words=Deferred("pipeline.run.corrected.maker", "corrected_words"),
                shown=((PATH_CSV, "the corrected path, densely sampled"), (CORRECTION_CSV, "the correction over s")),
                next_step=_NEXT,
            )
        return replace(spec, next_step=_NEXT) if spec.stage is Stage.RETIME else spec

    return tuple(changed(spec) for spec in SPECS)
