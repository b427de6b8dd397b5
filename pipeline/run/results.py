"""The results of a run: those it made, and those of earlier runs, loaded when first used."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar, cast

from pipeline.config import Config
from pipeline.config.choices import Proof
from pipeline.machine.geometry import Machine
from pipeline.run.config_parts import with_proof
from pipeline.run.stage_specs import SPECS, Specs, spec_of
from pipeline.stage import Stage

if TYPE_CHECKING:
    from pipeline.certify.recheck import KappaProfile, Statement
    from pipeline.refine.measure import PathSamples
    from pipeline.refine.result import Refinement
    from pipeline.retime.result import Trajectory
    from pipeline.route.regions.table import RegionTable
    from pipeline.route.result import Route
    from pipeline.run.beside.process import SecondProcess

_T = TypeVar("_T")


@dataclass
class Results:
    """The results of a run: those it made, and those of earlier runs, loaded when first used.

    Attributes
    ----------
    config : Config
        The configuration.
    machine : Machine
        The machine.
    folder : Path
        The run folder.
    specs : tuple of StageSpec
        The stages.
    recompute : bool
        Nothing that other runs computed is used.
    proof : Proof or None
        What is proven, whatever the configuration says; None: what it says.
    beside : SecondProcess or None
        Makes a part of the figures and the report, once it is begun.
    given : mapping
        Functions that give results of stages which were found elsewhere, for the same configuration.
    """

    config: Config
    machine: Machine
    folder: Path
    specs: Specs = SPECS
    recompute: bool = False
    proof: Proof | None = None
    beside: "SecondProcess | None" = None
    given: Mapping[Stage, Callable[[], Any]] = field(default_factory=dict)
    _known: dict[Stage, Any] = field(default_factory=dict, init=False, repr=False)
    _derived: dict[Callable[["Results"], Any], Any] = field(default_factory=dict, init=False, repr=False)

    def of(self, stage: Stage) -> Any:
        """Give the result of a stage."""
        if stage not in self._known:
            load = spec_of(self.specs, stage).load
            assert load is not None, f"{stage} has no result to load"
            self._known[stage] = load(self)
        return self._known[stage]

    def keep(self, stage: Stage, result: Any) -> None:
        """Take over a result that was just made."""
        self._known[stage] = result

    def derive(self, compute: "Callable[[Results], _T]") -> _T:
        """Give what a function derives from the results, computed once."""
        if compute not in self._derived:
            self._derived[compute] = compute(self)
        return cast("_T", self._derived[compute])

    @property
    def config_to_prove(self) -> Config:
        """The configuration, with the proof that is wanted."""
        return self.config if self.proof is None else with_proof(self.config, self.proof)

    @property
    def regions(self) -> "RegionTable":
        """The region table."""
        return cast("RegionTable", self.of(Stage.REGIONS))

    @property
    def route(self) -> "Route":
        """The route."""
        return cast("Route", self.of(Stage.ROUTE))

    @property
    def refinement(self) -> "Refinement":
        """The refined path and the coarse one."""
        return cast("Refinement", self.of(Stage.REFINE))

    @property
    def certificate(self) -> "Statement":
        """What the certificate's file states."""
        return cast("Statement", self.of(Stage.CERTIFY))

    @property
    def trajectory(self) -> "Trajectory":
        """The path in time."""
        return cast("Trajectory", self.of(Stage.RETIME))

    @property
    def samples(self) -> "tuple[PathSamples, PathSamples]":
        """Both paths, coarse and refined, sampled densely and in the same way."""
        from pipeline.run.makers.path_samples import sample_paths

        return self.derive(sample_paths)

    @property
    def profile(self) -> "KappaProfile | None":
        """The proven bound of kappa, box by box; None if no proof was asked for."""
        from pipeline.run.makers.proven_profile import proven_profile

        return self.derive(proven_profile)
