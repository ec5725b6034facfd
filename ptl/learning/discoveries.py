"""The row of the subgoal table for one learned task."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np


class SubgoalRow(NamedTuple):
    """Subgoal and peaks of the metrics after one task.

    Attributes
    ----------
    subgoal : int
        State that the library took up, -1 for none.
    novelty : float
        Mean length of the unknown rest of the paths, in steps.
    metric_value : float
        Greatest value of the incremental metric.
    reason : str
        Why the library took up the subgoal or none.
    incremental_peak, original_peak : int
        State where either metric is greatest, the first of several, whether the library took it up or not; -1 if
        the metric is 0 everywhere.
    """

    subgoal: int
    novelty: float
    metric_value: float
    reason: str
    incremental_peak: int
    original_peak: int


def subgoal_row(subgoal: int, reason: str, novelty: float, incremental: np.ndarray, original: np.ndarray) -> SubgoalRow:
    """Return the row of a task; the metrics are float arrays (n_states,)."""
    (value, peak), (_, original_peak) = _peak(incremental), _peak(original)
    return SubgoalRow(subgoal, novelty, value, reason, peak, original_peak)


def _peak(metric: np.ndarray) -> tuple[float, int]:
    """Return the greatest value of a metric, which is nowhere negative, and the first state that has it if above 0."""
    state = int(metric.argmax())
    value = float(metric[state])
    return value, state if value else -1
