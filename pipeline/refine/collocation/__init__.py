"""What the programs over collocation nodes share: data, rows, the smooth kappa, derivatives, and IPOPT."""
