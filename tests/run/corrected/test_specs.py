"""The stages of a corrected run: no regions and no route, and up to date as long as what it was made from is."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from pipeline.config import Config
from pipeline.machine import Machine, build_machine
from pipeline.run.corrected.maker import Planned
from pipeline.run.corrected.specs import corrected_specs
from pipeline.run.stage_specs import SPECS, spec_of, stages_up_to
from pipeline.run.up_to_date.fingerprint import fingerprint
from pipeline.stage import STAGES, Stage


def planned_by(config: Config, make: dict[str, Callable[..., Any]], machine: Machine | None = None) -> Planned:
    """Give a planned path, of the configured machine or of another one."""
    return Planned(make["refinement"](build_machine(config.machine) if machine is None else machine), config.machine)


def test_stages_follow_from_what_each_builds_on(fast_config: Config, make: dict[str, Callable[..., Any]]) -> None:
    """A usual run has all stages up to its last; a corrected one begins with its path."""
    assert stages_up_to(SPECS, Stage.FIGURES) == STAGES
    assert stages_up_to(SPECS, Stage.RETIME) == (*Stage.RETIME.earlier, Stage.RETIME)
    specs = corrected_specs(planned_by(fast_config, make))
    assert stages_up_to(specs, Stage.RETIME) == (Stage.REFINE, Stage.CERTIFY, Stage.RETIME)
    assert [spec.patterns for spec in specs] == [spec.patterns for spec in SPECS]


def test_a_corrected_path_depends_on_what_was_planned(
    fast_config: Config, make: dict[str, Callable[..., Any]], change: Callable[..., Config]
) -> None:
    """Another planned path, another machine it was planned for, and other zeros of encoders make it again."""

    def of(planned: Planned, config: Config) -> str:
        specs = corrected_specs(planned)
        return fingerprint(specs, Stage.REFINE, config, {})

    planned, machine = planned_by(fast_config, make), build_machine(fast_config.machine)
    longer = planned_by(fast_config, make, replace(machine, lengths_m=machine.lengths_m + 1e-3))
    zeros = change(fast_config, machine__actuators__c1__zero_m=1e-3)
    usual = of(planned, fast_config)
    assert usual == of(planned_by(fast_config, make), fast_config)
    others = [of(longer, fast_config), of(planned, zeros), of(replace(planned, machine=zeros.machine), fast_config)]
    assert len({usual, *others}) == 4
    assert spec_of(corrected_specs(planned), Stage.REFINE).upstream == ()
