"""Every machine within an ellipsoid of parameters, for many boxes at a time."""
