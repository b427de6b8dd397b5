"""A second process beside a run: it draws what stages one and two have found while later stages run.

It is a program of its own (`python -m pipeline.run.beside`) that reads the run folder and writes nothing: what it made
goes through a pipe to the run, which commits it with the figures. Nothing depends on it but time.
"""
