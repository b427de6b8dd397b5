"""Routes between all pairs of stations, over one region table and one set of moves.

`atlas/__init__.pyi` lists what is imported from here; nothing is loaded before it is used.
"""

import lazy_loader as lazy

__getattr__, __dir__, __all__ = lazy.attach_stub(__name__, __file__)
