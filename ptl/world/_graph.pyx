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


def breadth_first(int32_t[::1] first, int32_t[::1] neighbours, int32_t[::1] sources):
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
    """
    cdef Py_ssize_t n = first.shape[0] - 1, head = 0, tail = 0, i
    cdef int32_t vertex, other
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
