"""Faster motions against better kappa: curves of duration over the integral and the largest kappa."""

from pipeline.tradeoff.curve import MissingPoint, Tradeoff, TradeoffPoint, trade_off
from pipeline.tradeoff.table import TABLE_HEADER, missing_text, table_cells, tradeoff_data

__all__ = [
    "TABLE_HEADER",
    "MissingPoint",
    "Tradeoff",
    "TradeoffPoint",
    "missing_text",
    "table_cells",
    "trade_off",
    "tradeoff_data",
]
