"""Bounds on the cost of routes: shortest paths, budgets and their prices, the least cap on kappa."""
