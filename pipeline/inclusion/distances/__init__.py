"""Rigorous lower bounds of distances over a whole box."""
