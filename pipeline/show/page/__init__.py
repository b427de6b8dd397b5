"""The page itself: the only package that talks to viser."""
