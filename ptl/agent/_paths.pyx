# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
# cython: embedsignature=True
"""Sums over the loop-erased paths of a task: the loops of `ptl.agent.subgoals`.

Paths lie one after another in one array: path i is ``states[first[i]:end[i]]``. What is handed over is not checked.
"""

from libc.stdint cimport int32_t, int64_t, uint8_t

import numpy as np

cdef extern from *:
    """
    #ifndef PTL_SOURCE_DIGEST
    #define PTL_SOURCE_DIGEST "unknown"
    #endif
    """
    const char* PTL_SOURCE_DIGEST

SOURCE_DIGEST = PTL_SOURCE_DIGEST.decode()
"""sha256 of the sources that this extension was built from."""

DISTANCE_FORMS = ("tent", "parabola")
"""Forms of the distance at position j on a path of l steps: 0 at both ends, 1 half-way (our choice).

2 min(j, l - j) / l and 4 j (l - j) / l**2
"""


def frequency_and_distance(const int32_t[::1] states, const int64_t[::1] first, const int64_t[::1] end, int n_states,
                           form):
    """The share of the paths that contain each state, and the mean of its distance on those; both 0 without a path.

    A path of no steps has distance 0.

    Returns
    -------
    frequency, distance : float64 arrays, shape (n_states,)

    Raises
    ------
    ValueError
        If there is no such form.
    """
    if form not in DISTANCE_FORMS:
        raise ValueError(f"the form of the distance must be one of {', '.join(DISTANCE_FORMS)}, not {form!r}")
    cdef bint tent = form == "tent"
    cdef int64_t path, j, length, paths = first.shape[0]
    cdef int32_t state
    frequencies, distances = np.zeros(n_states), np.zeros(n_states)
    cdef double[::1] frequency = frequencies, distance = distances
    for path in range(paths):
        length = end[path] - first[path] - 1
        for j in range(length + 1):
            state = states[first[path] + j]
            frequency[state] += 1
            if length == 0:
                pass
            elif tent:
                distance[state] += 2.0 * min(j, length - j) / length
            else:
                distance[state] += 4.0 * (j * (length - j)) / (length * length)
    for state in range(n_states):
        if frequency[state]:
            distance[state] /= frequency[state]
            frequency[state] /= paths
    return frequencies, distances


def last_covered(const int32_t[::1] states, const int64_t[::1] first, const int64_t[::1] end,
                 const uint8_t[::1] covered):
    """The place of each path's last covered state, or of its first state if none is covered, int64 (paths,)."""
    cdef int64_t path, place
    result = np.array(first)
    cdef int64_t[::1] last = result
    for path in range(first.shape[0]):
        for place in range(end[path] - 1, first[path] - 1, -1):
            if covered[states[place]]:
                last[path] = place
                break
    return result
