"""Subgoal discovery: the FD metric of Kretchmar et al. and the article's incremental version of it.

Both work on the loop-erased paths of the first successful episodes of a task. The article states that the metric is the
product of frequency and distance, and that the incremental metric eliminates the known part; the form of the distance
and of the elimination are our choice.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ptl.agent._paths import frequency_and_distance, last_covered, states_before
from ptl.world.transitions import TransitionGraph, checked_states


@dataclass(frozen=True, repr=False)
class FDMetric:
    """Frequency and distance of every state over T paths; all arrays float (n_states,)."""

    frequency: np.ndarray
    distance: np.ndarray

    @property
    def product(self) -> np.ndarray:
        """f * d, whose argmax is the subgoal."""
        return self.frequency * self.distance


class _Laid(NamedTuple):
    """Paths one after another: path i is ``states[first[i]:end[i]]``."""

    states: np.ndarray
    first: np.ndarray
    end: np.ndarray


def _lay(paths: Sequence[np.ndarray], n_states: int) -> _Laid:
    sizes = np.array([len(path) for path in paths], dtype=np.int64)
    states = checked_states(np.concatenate(paths) if len(paths) else [], n_states)
    if states.ndim != 1 or not sizes.all():
        raise ValueError("a path must be a sequence of one or more states")
    end = sizes.cumsum()
    return _Laid(states, end - sizes, end)


def fd_metric(paths: Sequence[np.ndarray], n_states: int, form: str = "tent") -> FDMetric:
    """Compute frequency and distance over loop-erased paths (Kretchmar et al.; form of the distance: our choice).

    f(s) is the share of the paths that contain s. d(s) is the mean over those of a form of
    `ptl.agent._paths.DISTANCE_FORMS` at the position of s. A path of no steps counts in f and has distance 0.
    """
    return _metric(_lay(paths, n_states), n_states, form)


def _metric(paths: _Laid, n_states: int, form: str) -> FDMetric:
    return FDMetric(*frequency_and_distance(*paths, n_states, form))


def covered_states(graph: TransitionGraph, known: Sequence[int], radius: int) -> np.ndarray:
    """Return which states are within ``radius`` steps of a known state over seen transitions, bool (n_states,)."""
    steps = graph.steps_from(list(known))
    return (steps >= 0) & (steps <= radius)


def _cut(paths: _Laid, covered: np.ndarray) -> _Laid:
    """Return the rest of each path from its last covered state on; the whole path if none is covered."""
    return paths._replace(first=last_covered(*paths, covered.view(np.uint8)))


@dataclass(frozen=True)
class Discovery:
    """What the first successful episodes of a task say about subgoals, computed when it is asked for.

    Attributes
    ----------
    graph : TransitionGraph
        The transitions seen in the task.
    form : str
        Form of the distance, a name of `DISTANCE_FORMS`.
    """

    graph: TransitionGraph = field(repr=False)
    form: str
    _whole: _Laid = field(repr=False)
    _rests: _Laid = field(repr=False)

    @property
    def paths(self) -> list[np.ndarray]:
        """The loop-erased paths, from the task's start to its goal."""
        return [self._whole.states[first:end] for first, end in zip(self._whole.first, self._whole.end, strict=True)]

    @property
    def start(self) -> int:
        """The task's start; IndexError if no episode was successful."""
        return int(self._whole.states[0])

    @property
    def goal(self) -> int:
        """The task's goal; IndexError if no episode was successful."""
        return int(self._whole.states[-1])

    @cached_property
    def original(self) -> FDMetric:
        """The metric on the whole paths."""
        return _metric(self._whole, self.graph.n_states, self.form)

    @cached_property
    def incremental(self) -> FDMetric:
        """The metric on the rests of the paths beyond the part that the library knows."""
        return self.original if self._rests is self._whole else _metric(self._rests, self.graph.n_states, self.form)

    @cached_property
    def novelty(self) -> float:
        """Mean length of the rests in steps, 0 if there is none."""
        return float((self._rests.end - self._rests.first - 1).mean()) if len(self._rests.end) else 0.0

    @cached_property
    def diameter(self) -> int:
        """Maximum length of a shortest path between visited states, in steps."""
        return self.graph.diameter()

    def states_before(self, subgoal: int) -> np.ndarray:
        """Return the initiation set of a skill, bool (n_states,): the states before its subgoal on some path.

        That a skill can be taken where a path that led through its subgoal came from is the notion of McGovern and
        Barto (2001); that the paths are the loop-erased ones of the task that taught the skill is our choice.
        """
        return states_before(*self._whole, self.graph.n_states, subgoal).view(bool)


def discover(
    paths: Sequence[np.ndarray],
    graph: TransitionGraph,
    known: Sequence[int],
    cover_radius: int,
    form: str = "tent",
) -> Discovery:
    """Lay out the loop-erased paths of a task for both metrics.

    Parameters
    ----------
    paths : sequence of int arrays
        Loop-erased paths of the first T successful episodes, as states.
    graph : TransitionGraph
        The transitions seen in the task.
    known : sequence of int
        States that the library knew before this task, see `SkillLibrary.known_states`.
    cover_radius : int
        r, steps around these states that count as known too.
    form : str
        Form of the distance, a name of `DISTANCE_FORMS`.

    Raises
    ------
    ValueError
        If a path is empty, or it or the known states hold something that is not a state of the graph.
    """
    whole = _lay(paths, graph.n_states)
    rests = _cut(whole, covered_states(graph, known, cover_radius)) if len(known) else whole
    return Discovery(graph, form, whole, rests)
