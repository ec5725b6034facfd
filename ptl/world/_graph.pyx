# cython: language_level=3, boundscheck=False, wraparound=False, initializedcheck=False
"""Breadth-first search over a graph in compressed rows: the one graph routine that has to be fast."""

from libc.stdint cimport int32_t

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
    cdef Py_ssize_t n = first.shape[0] - 1, head = 0, tail = 0, i
    cdef int32_t vertex, other
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
    result = np.full(n, -1, dtype=np.int32)
    cdef int32_t[::1] distance = result
    cdef int32_t[::1] queue = np.empty(n, dtype=np.int32)
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
    return result
