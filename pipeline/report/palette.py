"""The colours of the page, on a light and on a dark ground.

For readers with normal sight, protanopia, deuteranopia and tritanopia, curves of one plot differ by at least 0.13 in
OKLab, lines of the 3-D view by 0.1. They stand out from their ground by a contrast of at least 3 (WCAG 1.4.11),
text by 4.5 (1.4.3).
"""

from dataclasses import dataclass

import matplotlib as mpl
import numpy as np
from matplotlib.colors import to_hex

_MAP_COLOURS = 9


@dataclass(frozen=True)
class Palette:
    """Colours as #rrggbb.

    Attributes
    ----------
    text, soft, line, ground, panel : str
        Text, text of less weight, thin lines, the page, areas on it.
    good, bad, open, focus : str
        Moods of statements; controls and what has the focus.
    button : str
        Text on a control.
    refined, coarse, bound : str
        The paths, and the proven bound.
    first, second, third : str
        Curves of one plot; in 3-D fixed links, carts right of their joints, and telescopes.
    rail, platform, frame, near : str
        In 3-D; bodies that are near each other.
    limit, change : str
        Lines at limits, and at changes of working mode.
    """

    text: str
    soft: str
    line: str
    ground: str
    panel: str
    good: str
    bad: str
    open: str
    focus: str
    button: str
    refined: str
    coarse: str
    bound: str
    first: str
    second: str
    third: str
    rail: str
    platform: str
    frame: str
    near: str
    limit: str
    change: str


LIGHT = Palette(
    text="#1B1F24",
    soft="#535C66",
    line="#D5DAE0",
    ground="#FFFFFF",
    panel="#F3F5F8",
    good="#00664A",
    bad="#A33B00",
    open="#535C66",
    focus="#0B63B5",
    button="#FFFFFF",
    refined="#C8500A",
    coarse="#1B1F24",
    bound="#2279D6",
    first="#2279D6",
    second="#B8640A",
    third="#0A553D",
    rail="#857F78",
    platform="#7A1F96",
    frame="#1B1F24",
    near="#FF3364",
    limit="#6B747E",
    change="#6B747E",
)

DARK = Palette(
    text="#E6EAEE",
    soft="#A3ADB8",
    line="#39424C",
    ground="#14181D",
    panel="#1E242B",
    good="#4FD1A5",
    bad="#FF9A66",
    open="#A3ADB8",
    focus="#5CB0F5",
    button="#14181D",
    refined="#FF8A45",
    coarse="#E6EAEE",
    bound="#4B9CF5",
    first="#4B9CF5",
    second="#F08A3C",
    third="#A2F0DC",
    rail="#8C8C8C",
    platform="#ADBACC",
    frame="#E6EAEE",
    near="#FF2244",
    limit="#97A1AB",
    change="#97A1AB",
)

SINGULAR, OUT_OF_REACH = "#F0E442", "#DDDDDD"
MAP = tuple(to_hex(mpl.colormaps["Blues"](part)) for part in np.linspace(0.0, 1.0, _MAP_COLOURS))
"""Maps of kappa have the same colours on both grounds, so that the same value always looks the same."""
