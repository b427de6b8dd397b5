"""The tabs of the page: one module each, which adds its controls and asks for what they stand for."""
