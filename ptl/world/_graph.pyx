# cython: language_level=3, boundscheck=False, wraparound=False, initializedcheck=False
"""Searches of a graph in compressed rows: the graph routines that have to be fast."""

from libc.stdint cimport int32_t, int64_t, uint8_t
from libc.string cimport memset

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


ctypedef fused whole:
    int32_t
    int64_t


cdef bint among(const whole[::1] numbers, int64_t n) noexcept:
    """Whether all numbers are from 0 to n - 1."""
    cdef Py_ssize_t i
    for i in range(numbers.shape[0]):
        if not 0 <= numbers[i] < n:
            return False
    return True


def checked_states(states, int64_t n_states):
    """States as int32, an array of int32 itself; ValueError if one is no whole number from 0 to n_states - 1."""
    given = np.asarray(states, order="C")
    if given.size == 0:
        return given.astype(np.int32)
    cdef bint right = False
    if given.dtype == np.int32:
        right = among[int32_t](given.reshape(-1), n_states)
    elif given.dtype.kind in "iu":  # what int64 does not hold becomes negative
        right = among[int64_t](given.astype(np.int64).reshape(-1), n_states)
    if not right:
        raise ValueError(f"a state must be a whole number from 0 to {n_states - 1}, not {states!r}")
    return given.astype(np.int32, copy=False)


def compressed_rows(const int32_t[:, ::1] successors not None, const uint8_t[:, ::1] known not None,
                    bint forward, bint backward):
    """The graph of known transitions, each in one or both of its directions, without edges from a state to itself.

    Parameters
    ----------
    successors : int32 array, shape (n, actions)
    known : uint8 array, shape (n, actions)
        Whether a transition is an edge.
    forward, backward : bool

    Returns
    -------
    first : int32 array, shape (n + 1,)
    neighbours : int32 array
        As `breadth_first` takes them.

    Raises
    ------
    ValueError
        If a successor is not a state, or the shapes differ.
    """
    check_successors(successors, known)
    cdef Py_ssize_t n = successors.shape[0], state, action
    cdef int32_t other, total = 0, size
    rows = np.zeros(n + 1, dtype=np.int32)
    cdef int32_t[::1] first = rows
    for state in range(n):
        for action in range(successors.shape[1]):
            other = successors[state, action]
            if known[state, action] and other != state:
                first[state] += forward
                first[other] += backward
    for state in range(n + 1):
        size = first[state]
        first[state] = total  # the next place in the row, which moves to the end of the row below
        total += size
    ends = np.empty(total, dtype=np.int32)
    cdef int32_t[::1] neighbours = ends
    for state in range(n):
        for action in range(successors.shape[1]):
            other = successors[state, action]
            if known[state, action] and other != state:
                if forward:
                    neighbours[first[state]] = other
                    first[state] += 1
                if backward:
                    neighbours[first[other]] = <int32_t>state
                    first[other] += 1
    for state in range(n, 0, -1):
        first[state] = first[state - 1]
    first[0] = 0
    return rows, ends


def breadth_first(const int32_t[::1] first, const int32_t[::1] neighbours, const int32_t[::1] sources):
    """Steps from the nearest source to every vertex.

    Parameters
    ----------
    first : int32 array, shape (n + 1,)
        The neighbours of vertex v are ``neighbours[first[v]:first[v + 1]]``.
    neighbours : int32 array
    sources : int32 array
        Vertices at distance 0.

    Returns
    -------
    int32 array, shape (n,)
        -1 where no path leads.

    Raises
    ------
    ValueError
        If the rows are not those of a graph or a source is not a vertex of it.
    """
    if first is None or neighbours is None or sources is None or not first.shape[0]:
        raise ValueError("first, neighbours and sources must be int32 arrays, first with one entry more than vertices")
    cdef Py_ssize_t n = first.shape[0] - 1, i
    if first[0] < 0 or first[n] > neighbours.shape[0]:
        raise ValueError("first goes beyond the neighbours")
    for i in range(n):
        if first[i] > first[i + 1]:
            raise ValueError("first must not fall")
    for i in range(neighbours.shape[0]):
        if not 0 <= neighbours[i] < n:
            raise ValueError(f"a neighbour must be a vertex from 0 to {n - 1}, not {neighbours[i]}")
    for i in range(sources.shape[0]):
        if not 0 <= sources[i] < n:
            raise ValueError(f"a source must be a vertex from 0 to {n - 1}, not {sources[i]}")
    result = np.empty(n, dtype=np.int32)
    cdef int32_t[::1] distance = result, queue = np.empty(n, dtype=np.int32)
    if n:
        search(first, neighbours, sources, &distance[0], &queue[0])
    return result


def first_steps(const int32_t[:, ::1] successors not None, const uint8_t[:, ::1] known not None,
                const int32_t[::1] steps not None):
    """The first known action of each state that leads one step nearer, -1 where none does.

    Parameters
    ----------
    successors, known : as in `compressed_rows`
    steps : int32 array, shape (n,)
        Steps from each state, -1 where no path leads.

    Returns
    -------
    int8 array, shape (n,)

    Raises
    ------
    ValueError
        If a successor is not a state, or the shapes differ.
    """
    check_successors(successors, known)
    if steps.shape[0] != successors.shape[0]:
        raise ValueError(f"there must be steps for each of {successors.shape[0]} states, not for {steps.shape[0]}")
    cdef Py_ssize_t state, action
    result = np.full(successors.shape[0], -1, dtype=np.int8)
    cdef signed char[::1] policy = result
    for state in range(successors.shape[0]):
        if steps[state] <= 0:
            continue
        for action in range(successors.shape[1]):
            if known[state, action] and steps[successors[state, action]] == steps[state] - 1:
                policy[state] = <signed char>action
                break
    return result


cdef int check_successors(const int32_t[:, ::1] successors, const uint8_t[:, ::1] known) except -1:
    cdef Py_ssize_t state, action, n = successors.shape[0]
    if known.shape[0] != n or known.shape[1] != successors.shape[1]:
        raise ValueError("successors and known must have the same shape")
    for state in range(n):
        for action in range(successors.shape[1]):
            if not 0 <= successors[state, action] < n:
                raise ValueError(f"a successor must be a state from 0 to {n - 1}, not {successors[state, action]}")
    return 0


cdef int64_t n_searches = 0


def searches():
    """Breadth-first searches that this module has made so far."""
    return n_searches


cdef Py_ssize_t search(const int32_t[::1] first, const int32_t[::1] neighbours, const int32_t[::1] sources,
                       int32_t* distance, int32_t* queue) noexcept:
    """Write the distances, -1 where no path leads, and the vertices reached, nearest first; return their number."""
    global n_searches
    cdef Py_ssize_t head = 0, tail = 0, i
    cdef int32_t vertex, other
    n_searches += 1
    memset(distance, 255, (first.shape[0] - 1) * sizeof(int32_t))
    for i in range(sources.shape[0]):
        if distance[sources[i]] < 0:
            distance[sources[i]] = 0
            queue[tail] = sources[i]
            tail += 1
    while head < tail:
        vertex = queue[head]
        head += 1
        for i in range(first[vertex], first[vertex + 1]):
            other = neighbours[i]
            if distance[other] < 0:
                distance[other] = distance[vertex] + 1
                queue[tail] = other
                tail += 1
    return tail


def diameter(const int32_t[:, ::1] successors not None, const uint8_t[:, ::1] known not None):
    """The longest shortest path between connected states over known transitions in both directions.

    Exact, by bounding the eccentricities from few searches (Takes and Kosters, 2011) instead of one from each vertex:
    d(v, w) <= ecc(w) <= ecc(v) + d(v, w) and ecc(w) >= ecc(v) - d(v, w).

    Parameters
    ----------
    successors, known
        As in `compressed_rows`, with its errors.
    """
    cdef const int32_t[::1] first, neighbours
    first, neighbours = compressed_rows(successors, known, True, True)
    cdef Py_ssize_t n = first.shape[0] - 1, i, k, reached, kept, number
    cdef int32_t longest = 0, vertex, eccentricity
    cdef bint take_highest
    cdef int32_t[::1] distance = np.empty(n, dtype=np.int32), queue = np.empty(n, dtype=np.int32)
    cdef int32_t[::1] open_ = np.empty(n, dtype=np.int32), pick = np.empty(1, dtype=np.int32)
    cdef int32_t[::1] lower = np.zeros(n, dtype=np.int32), upper = np.full(n, n, dtype=np.int32)
    for i in range(n):
        if upper[i] < n or first[i] == first[i + 1]:
            continue  # of a component that is done, or alone
        pick[0] = <int32_t>i
        kept = 0
        take_highest = True
        while True:
            reached = search(first, neighbours, pick, &distance[0], &queue[0])
            if not kept:
                for kept in range(reached):
                    open_[kept] = queue[kept]
                kept = reached
            eccentricity = distance[queue[reached - 1]]
            longest = max(longest, eccentricity)
            upper[pick[0]] = eccentricity
            number, kept = kept, 0
            for k in range(number):
                vertex = open_[k]
                lower[vertex] = max(lower[vertex], max(distance[vertex], eccentricity - distance[vertex]))
                upper[vertex] = min(upper[vertex], eccentricity + distance[vertex])
                if upper[vertex] > longest and lower[vertex] < upper[vertex]:
                    open_[kept] = vertex
                    kept += 1
            if not kept:
                break
            # In turn a vertex that may be far out (raises the lower bound) and one that is central (lowers the upper).
            pick[0] = open_[0]
            for k in range(1, kept):
                vertex = open_[k]
                if upper[vertex] > upper[pick[0]] if take_highest else lower[vertex] < lower[pick[0]]:
                    pick[0] = vertex
            take_highest = not take_highest
    return longest
