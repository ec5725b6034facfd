"""Numbers as readers see them: no more digits than an interval supports."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ptl.text import estimate, interval, number, place_of


@pytest.mark.parametrize(
    ("numbers", "text"),
    [
        ((15261.3, 5238.0, 24907.0), "15,000 [5,000, 25,000]"),
        ((82.31, 81.37, 83.29), "82.3 [81.4, 83.3]"),
        ((0.88662, 0.8731, 0.9012), "0.887 [0.873, 0.901]"),
        ((91.0, 91.0, 91.0), "91"),
        ((12.5, math.nan, math.nan), "12.5"),
    ],
)
def test_an_estimate_has_the_digits_of_its_interval(numbers: tuple[float, float, float], text: str) -> None:
    assert estimate(*numbers) == text


@given(st.floats(1e-6, 1e6), st.floats(1e-3, 1e6))
def test_rounding_moves_an_end_by_less_than_a_sixth_of_half_the_width(low: float, width: float) -> None:
    """As long as the number keeps fewer than four digits, which is the most that is ever printed."""
    place = place_of(low, low + width)
    assert place is not None
    shown = float(number(low, place).replace(",", ""))
    assert abs(shown - low) <= max(width / 2 / 6, 5e-4 * low, 5e-4) * (1 + 1e-9)


def test_no_interval_no_place() -> None:
    assert place_of(math.nan, 1.0) is None and place_of(2.0, 2.0) is None
    assert interval(math.nan, math.nan) == ""
