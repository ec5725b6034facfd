"""Numbers as readers see them: one form for a value, wherever it is printed."""

from __future__ import annotations

import math
from numbers import Integral

MINUS = "−"
MISSING = "–"
"""Text for a missing value."""


def number(value: float, place: int | None = None) -> str:
    """Format a number.

    Whole numbers (``int``) keep all digits; others keep four significant digits, but never more than three decimals
    unless they would vanish. Thousands are separated by commas: 302833 -> 302,833; 15261.3 -> 15,260; 0.88662 -> 0.887.
    ``place`` is the number of decimals at most (negative: tens, hundreds, ...), see `place_of`.
    """
    if isinstance(value, Integral):
        return _signed(f"{int(value):,}")
    if not math.isfinite(value):
        return MISSING if math.isnan(value) else _signed("∞" if value > 0 else "-∞")
    if value == 0:
        return "0"
    own = 3 - math.floor(math.log10(abs(value)))
    if abs(value) >= 0.001:
        own = min(own, 3)
    if place is not None:
        own = min(own, place)
    rounded = round(value, own)
    text = f"{rounded:,.{max(own, 0)}f}"
    return _signed(text.rstrip("0").rstrip(".") if "." in text else text)


def place_of(low: float, high: float) -> int | None:
    """Return the decimals that an interval supports: a unit of the last one is 3 to 33% of half its width.

    None if there is no interval, or one of no width.
    """
    half = (high - low) / 2
    return -math.floor(math.log10(half / 3)) if math.isfinite(half) and half > 0 else None


def percent(share: float) -> str:
    """Format a share of 1 as a percentage: 0.95 -> 95%."""
    return f"{number(100 * share)}%"


def interval(low: float, high: float) -> str:
    """Format the ends of an interval, as precisely as its width allows; empty if there is none."""
    place = place_of(low, high)
    return "" if math.isnan(low) or math.isnan(high) else f"[{number(low, place)}, {number(high, place)}]"


def estimate(value: float, low: float, high: float, unit: str = "") -> str:
    """Format a value with its interval and unit: 81% [74, 85]; an interval of no width is left out."""
    shown = number(value, place_of(low, high)) + ("%" if unit == "%" else "")
    limits = "" if low == value == high else interval(low, high)
    return " ".join(part for part in (shown, limits, "" if unit == "%" else unit) if part)


def _signed(text: str) -> str:
    if text.startswith("-"):
        return MINUS + text[1:] if text != "-0" else "0"
    return text
