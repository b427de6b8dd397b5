"""The configuration: one YAML file that describes machine, task and the options of every stage.

Units are part of the key names. Unknown keys are refused; every message names the key's path, the value
found there and what is allowed. `load_config` reads a file; `Config.model_json_schema()` is its schema.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
