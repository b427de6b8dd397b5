"""The solvers, one module each, and what Ctrl-C does to them: no stage talks to one directly."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
