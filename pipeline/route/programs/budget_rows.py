"""Budgets as rows of the programs over all regions: each change gets a column as upper bound, their sum a limit."""

from collections.abc import Callable

import numpy as np

from pipeline.route.bounds.budgets import Budget
from pipeline.route.programs.rows import Rows, Term


def change_columns(budgets: tuple[Budget, ...], step_budget: int) -> int:
    """How many columns `add_budgets` needs: one per budget, coordinate and change between steps."""
    return sum(len(budget.coordinates) for budget in budgets) * (step_budget - 1)


def change_entries(budgets: tuple[Budget, ...], step_budget: int, terms: tuple[int, ...]) -> int:
    """Count the matrix entries of `add_budgets`, where coordinate k at a step is a term of `terms[k]` columns."""
    per_change = sum(2 * (1 + 2 * terms[k]) + 1 for budget in budgets for k in budget.coordinates)
    return per_change * (step_budget - 1)


def add_budgets(
    rows: Rows, budgets: tuple[Budget, ...], value: Callable[[int, int], Term], step_budget: int, first: int
) -> None:
    """Add |change of each coordinate| <= its column, and the sum of the columns <= the budget's limit.

    Parameters
    ----------
    value : callable
        Gives the term that a coordinate (as of `Budget.coordinates`) is at a step: value(step, coordinate).
    first : int
        The first of the columns for changes.
    """
    column = first
    for budget in budgets:
        begin = column
        for coordinate in budget.coordinates:
            for i in range(1, step_budget):
                (ahead, there), (behind, here) = value(i, coordinate), value(i - 1, coordinate)
                for sign in (1.0, -1.0):
                    change = [(ahead, -sign * there), (behind, sign * here)]
                    rows.add("budget, change", [(np.array([column]), np.ones(1)), *change], 0.0, np.inf)
                column += 1
        rows.add("budget", [(np.arange(begin, column), np.ones(column - begin))], -np.inf, budget.limit)
