"""Measures of a run and estimates with intervals, computed from its files."""
