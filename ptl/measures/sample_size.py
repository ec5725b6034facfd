"""Number of runs that an interval needs; a module without heavy imports, because figures and captions use it."""

MIN_FOR_INTERVAL = 5
"""Minimum number of values for an interval (our choice): with two to four of them the bootstrap draws from so few
different resamples that its interval holds the mean far less often than it promises."""


def note(runs: int, interval: str) -> str:
    """Return the caption text after "mean over N runs": the interval, or why it is missing."""
    return f" with {interval}" if runs >= MIN_FOR_INTERVAL else f" (no interval: fewer than {MIN_FOR_INTERVAL})"
