"""An atlas as a folder that grows: routes of all pairs of stations first, then motions where they are asked for."""

from pipeline.run.atlas.build import AtlasOptions, make_atlas

__all__ = ["AtlasOptions", "make_atlas"]
