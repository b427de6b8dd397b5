"""Singularity-free assembly-mode reconfiguration of 5-DOF Gantry-Tau machines, from a YAML file to the controller.

The names that the stub `__init__.pyi` imports are the public interface: at run time each is loaded when it is first
used, with the libraries it needs; type checkers and editors read the stub itself. Functions are pure unless their names
say otherwise (`load_`, `save_`, `open_`, `run_`): they neither print nor write.
"""

from . import startup as _startup  # noqa: F401  # first, since the next one takes longer

# isort: split
import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
