from .highs import (
    LinearProgram as LinearProgram,
)
from .highs import (
    Outcome as Outcome,
)
from .highs import (
    solve_program as solve_program,
)
from .highs import (
    solver_name as solver_name,
)
from .highs import (
    write_program as write_program,
)
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
from .topp_ra import (
    fastest_profile as fastest_profile,
)
