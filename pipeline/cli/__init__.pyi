from .application import (
    app as app,
)
from .process import (
    main as main,
)
