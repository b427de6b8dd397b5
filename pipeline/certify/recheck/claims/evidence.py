"""What the bounds of a certificate are checked against."""

from dataclasses import dataclass

from pipeline.certify.recheck.arithmetic.chain import EvaluatedChain
from pipeline.config import Config
from pipeline.machine.geometry import Machine
from pipeline.route.regions.endpoints import Endpoint


@dataclass(frozen=True, eq=False)
class Evidence:
    """What the configuration asks for, and the chain of the configured machine.

    Attributes
    ----------
    config, machine : Config, Machine
        The configuration and its machine, from which limits are read.
    ends : (Endpoint, Endpoint)
        Start and goal of the task.
    chain : EvaluatedChain
        Boxes and joints with their inclusions.
    """

    config: Config
    machine: Machine
    ends: tuple[Endpoint, Endpoint]
    chain: EvaluatedChain
