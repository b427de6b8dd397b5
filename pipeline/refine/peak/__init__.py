"""The largest kappa brought down: sequential quadratic programs over the spline coefficients."""
