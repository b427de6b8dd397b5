"""Path and time law found together: q(tau), tau = t / T with T free, within all limits of motion at every instant."""
