"""Kinds of limit that concern bodies."""
