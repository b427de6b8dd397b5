"""The solvers, one module each: no stage talks to one directly. HiGHS, IPOPT, PIQP, TOPP-RA, and what Ctrl-C does to them."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
