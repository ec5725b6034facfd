"""Cost of the library: operations are really counted, and a costlier selection shows."""

from __future__ import annotations

import numpy as np
import pytest

from ptl.agent.selection import prior
from ptl.errors import UserError
from ptl.measures import library_cost
from ptl.measures.library_cost import Counter, library_bytes, selection_operations
from ptl.report.figures.library_cost import cost_frame


@pytest.mark.parametrize(
    ("work", "operations"),
    [
        (lambda x: x * 2, 100),
        (lambda x: 2 - x, 100),
        (lambda x: (x + x) * x, 200),
        (lambda x: x.sum(), 100),
        (np.sum, 100),
        (np.cumsum, 100),
        (lambda x: x[:7], 7),
        (lambda x: x[3], 1),
        (lambda x: np.where(x > 5, x, 0), 200),
        (lambda x: np.multiply.outer(x, x), 100 * 100),
        (lambda x: np.searchsorted(x, 40.5), 7),
        (len, 0),
    ],
)
def test_operations_are_counted(work, operations):
    counter = Counter()
    values = counter.array(np.arange(100.0))
    found = work(values)
    assert counter.operations == operations
    np.testing.assert_array_equal(found, work(np.arange(100.0)))


def test_arrays_computed_from_a_counted_one_are_counted_too():
    counter = Counter()
    squares = counter.array(np.arange(10)) ** 2
    before = counter.operations
    _ = squares + 1
    assert counter.operations == before + 10


def test_a_function_that_cannot_be_counted_is_refused():
    with pytest.raises(TypeError, match=r"numpy\.dot cannot be counted"):
        np.dot(Counter().array(np.ones(3)), np.ones(3))


def test_a_selection_costs_the_same_for_each_skill():
    counts = selection_operations([100, 200, 400]).set_index("skills")["operations"]
    assert counts[400] - counts[200] == 2 * (counts[200] - counts[100])


def test_a_quadratic_prior_shows(monkeypatch):
    def slow(*arguments):
        chances = prior(*arguments)
        return chances + 0 * np.multiply.outer(chances, chances).sum()

    monkeypatch.setattr(library_cost, "prior", slow)
    counts = selection_operations([500, 1000])["operations"]
    assert counts[1] / counts[0] > 3.5


def test_the_draw_is_counted():
    counter = Counter()
    rows = selection_operations([300])["operations"]
    prior(counter.array(np.zeros((300, 2), dtype=int)), counter.visited(range(300)), 0, 1000.0)
    assert rows[0] - counter.operations >= 4 * 300


def test_numbers_of_the_figure():
    selection_cost = selection_operations([1, 10, 100])
    frame = cost_frame(selection_cost, library_bytes([20, 50], [1, 3]))
    part = frame[frame["kind"] == "selection"]
    assert part["operations"].tolist() == selection_cost["operations"].tolist()
    assert part["operations_per_skill"].unique() == pytest.approx([27], rel=0.01)
    assert frame.loc[frame["kind"] == "storage", "bytes"].tolist() == [24, 72, 54, 162]
    with pytest.raises(UserError, match="two library sizes"):
        cost_frame(selection_cost[:1], library_bytes([20]))
