# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""Subgoals of very many short tasks: the loop over tasks and the FD metric around the episode kernel.

It does for every goal what `ptl.learning.life` and `ptl.agent.subgoals.fd_metric` do for one (tests hold them together); it is
compiled because half a million tasks of thirty episodes leave no time for anything between the episodes.
"""

from libc.stdint cimport int32_t, int64_t, uint32_t

import numpy as np

from ptl.agent._kernel cimport Dynamics, Learner

from ptl.agent._kernel import Learner as _Learner

cdef extern from *:
    """
    #ifndef PTL_SOURCE_DIGEST
    #define PTL_SOURCE_DIGEST "unknown"
    #endif
    """
    const char* PTL_SOURCE_DIGEST

SOURCE_DIGEST = PTL_SOURCE_DIGEST.decode()
"""sha256 of the sources that this extension was built from."""

cdef int64_t NO_LIMIT = <int64_t>1 << 62


def subgoals_from(Dynamics dynamics, int start, goals, bit_generator, int trajectories, int attempts, *,
                  alpha, gamma, epsilon, max_steps, shortcut=True):
    """The subgoal of the original FD metric for the tasks from one start to each of several goals.

    Every task is learned from Q = 0 until ``trajectories`` episodes have reached the goal; random numbers go on from
    task to task.

    Parameters
    ----------
    start : int
    goals : sequence of int
        Goals, each other than the start.
    trajectories : int
        T, successful episodes a task.
    attempts : int
        Episodes after which a task is given up.

    Returns
    -------
    subgoals : int32 array, shape (len(goals),)
        Argmax of f * d; -1 if it is 0 everywhere (adjacent cells); -2 if the task was given up.
    total_steps : int
        Primitive steps of all episodes.
    """
    cdef Learner learner = _Learner(dynamics, 0, bit_generator, alpha=alpha, gamma=gamma, epsilon=epsilon,
                                    max_steps=max_steps, shortcut=shortcut)
    learner.notes_pairs = False
    cdef int n = dynamics.n_states, goal, successes, episode, length, j, i, best
    cdef int64_t total_steps = 0
    cdef double metric, highest
    cdef int32_t[::1] targets = np.ascontiguousarray(goals, dtype=np.int32)
    result = np.empty(len(targets), dtype=np.int32)
    cdef int32_t[::1] subgoals = result
    cdef uint32_t[::1] path = np.empty(n, dtype=np.uint32)
    cdef double[::1] distance = np.zeros(n)
    cdef int32_t[::1] visits = np.zeros(n, dtype=np.int32)
    if not 0 <= start < n or (len(targets) and not (0 <= min(targets) and max(targets) < n)) or start in targets:
        raise ValueError("start and goals must be different states")

    with nogil:
        for i in range(targets.shape[0]):
            goal = targets[i]
            learner.forget(goal)
            visits[:] = 0
            distance[:] = 0
            successes = 0
            for episode in range(attempts):
                learner.enter(start)
                learner.run_greedily(NO_LIMIT, learner.epsilon)
                total_steps += learner.taken
                if learner.here != learner.goal:
                    continue
                length = learner.erase_loops(&path[0])
                for j in range(length + 1):
                    visits[path[j]] += 1
                    distance[path[j]] += 2.0 * min(j, length - j) / length
                successes += 1
                if successes == trajectories:
                    break
            best, highest = -1, 0.0
            for j in range(n):
                if visits[j]:
                    metric = (<double>visits[j] / successes) * (distance[j] / visits[j])
                    if metric > highest:
                        best, highest = j, metric
            subgoals[i] = best if successes == trajectories else -2
    return result, total_steps
