"""Every machine within an ellipsoid of parameters: what they change of the closures, and how far they move joints."""
