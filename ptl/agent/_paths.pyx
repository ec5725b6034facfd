# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
# cython: embedsignature=True
"""Sums over the loop-erased paths of a task: the loops of `ptl.agent.subgoals`.

Paths lie one after another in one array: path i is ``states[first[i]:end[i]]``.
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


def frequency_and_distance(const int32_t[::1] states not None, const int64_t[::1] first not None,
                           const int64_t[::1] end not None, int n_states, form):
    """The share of the paths that contain each state, and the mean of its distance on those; both 0 without a path.

    A path of no steps has distance 0.

    Returns
    -------
    frequency, distance : float64 arrays, shape (n_states,)

    Raises
    ------
    ValueError
        If there is no such form, or the paths do not lie in the array or not on the map.
    """
    if form not in DISTANCE_FORMS:
        raise ValueError(f"the form of the distance must be one of {', '.join(DISTANCE_FORMS)}, not {form!r}")
    check_paths(states, first, end, n_states)
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


def last_covered(const int32_t[::1] states not None, const int64_t[::1] first not None,
                 const int64_t[::1] end not None, const uint8_t[::1] covered not None):
    """The place of each path's last covered state, or of its first state if none is covered, int64 (paths,).

    Errors as in `frequency_and_distance`.
    """
    check_paths(states, first, end, covered.shape[0])
    cdef int64_t path, place
    result = np.array(first)
    cdef int64_t[::1] last = result
    for path in range(first.shape[0]):
        for place in range(end[path] - 1, first[path] - 1, -1):
            if covered[states[place]]:
                last[path] = place
                break
    return result


def states_before(const int32_t[::1] states not None, const int64_t[::1] first not None,
                  const int64_t[::1] end not None, int n_states, int32_t state):
    """Which states come before the first place of a state on some path, uint8 (n_states,).

    Errors as in `frequency_and_distance`.
    """
    check_paths(states, first, end, n_states)
    cdef int64_t path, place, earlier
    result = np.zeros(n_states, dtype=np.uint8)
    cdef uint8_t[::1] before = result
    for path in range(first.shape[0]):
        for place in range(first[path], end[path]):
            if states[place] == state:
                for earlier in range(first[path], place):
                    before[states[earlier]] = True
                break
    return result


cdef int check_paths(const int32_t[::1] states, const int64_t[::1] first, const int64_t[::1] end,
                     Py_ssize_t n_states) except -1:
    cdef Py_ssize_t i
    if end.shape[0] != first.shape[0]:
        raise ValueError(f"{first.shape[0]} paths must have as many ends, not {end.shape[0]}")
    for i in range(first.shape[0]):
        if not 0 <= first[i] < end[i] <= states.shape[0]:
            raise ValueError(f"path {i} does not lie in the array of {states.shape[0]} states")
    for i in range(states.shape[0]):
        if not 0 <= states[i] < n_states:
            raise ValueError(f"a state must be a whole number from 0 to {n_states - 1}, not {states[i]}")
    return 0
