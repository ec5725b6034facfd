"""How many runs an interval needs; light, because figures and captions ask too."""

MIN_FOR_INTERVAL = 5
"""Minimum number of values for an interval (our choice): with two to four of them the bootstrap draws from so few
different resamples that its interval holds the mean far less often than it promises."""


def note(runs: int, interval: str) -> str:
    """Return what a caption says after "mean over N runs": the interval, or why there is none."""
    return f" with {interval}" if runs >= MIN_FOR_INTERVAL else f" (no interval: fewer than {MIN_FOR_INTERVAL})"
