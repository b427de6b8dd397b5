"""How far the joints at both ends of a link can turn."""
