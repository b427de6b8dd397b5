from .interrupts import (
    interrupts_noted as interrupts_noted,
)
from .ipopt import (
    Iteration as Iteration,
)
from .ipopt import (
    run_ipopt as run_ipopt,
)
from .qp import (
    DampedProgram as DampedProgram,
)
