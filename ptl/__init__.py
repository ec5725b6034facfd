"""Partial transfer learning with a skill library, in grid worlds."""

__version__ = "1.0.0"
