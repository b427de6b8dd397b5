"""The least integral of kappa: a nonlinear program over poses, actuators and splines, solved by IPOPT."""
