"""Floods verified by other code: Taylor forms in enclosures, H in the world's frame, components from the tree alone."""
