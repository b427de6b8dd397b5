"""Planning in a process of its own: it tells how far it is, and can be stopped.

It is a process rather than a thread, so that the page stays quick, and solvers can be interrupted.
"""
