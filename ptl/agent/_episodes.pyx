# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
# cython: embedsignature=True
"""The loop over the episodes of a task, for methods that describe an episode by a `ptl.agent.plan.Plan`."""

cimport cython
from libc.math cimport rint
from libc.stdint cimport int32_t, int64_t, uint8_t, uint32_t, uint64_t

import numpy as np

from ptl.agent._kernel cimport ALL_ACTIONS, NO_STATE, Learner, checked_index

from ptl.agent._kernel import check_mixing, checked_policy

cdef extern from *:
    """
    #ifndef PTL_SOURCE_DIGEST
    #define PTL_SOURCE_DIGEST "unknown"
    #endif
    """
    const char* PTL_SOURCE_DIGEST

SOURCE_DIGEST = PTL_SOURCE_DIGEST.decode()
"""sha256 of the sources that this extension was built from."""

cdef int64_t CANDIDATES = <int64_t>1 << 31  # numbers of candidates that a result file holds
cdef double LONGEST_PATIENCE = 1e18  # as in `ptl.agent.plan`


@cython.final
cdef class Led:
    """What a guide says, checked and copied once."""

    cdef object guide
    cdef const signed char[::1] policy
    cdef const uint8_t[::1] initiation  # None if it has no initiation set
    cdef uint32_t subgoal               # NO_STATE if it has none

    def __cinit__(self, guide, int n_states):
        self.guide = guide
        self.policy = checked_policy(guide.policy, n_states)
        self.subgoal = NO_STATE
        if guide.subgoal is not None:
            self.subgoal = <uint32_t>checked_index("subgoal", guide.subgoal, n_states)
        self.initiation = None
        if guide.initiation is not None:
            states = np.array(guide.initiation)
            if states.dtype != bool or states.shape != (n_states,):
                raise ValueError(f"an initiation set must be a bool array of {n_states} states, not {states.dtype} array"
                                 f" of the shape {states.shape}")
            self.initiation = states.view(np.uint8)


@cython.final
cdef class Run:
    """The episodes of one task under one plan."""

    cdef Learner learner
    cdef object draw, guide, note
    cdef dict led                 # `Led` by candidate
    cdef bint mixes
    cdef double psi, decay, patience, growth
    cdef uint64_t epsilon
    cdef int64_t[::1] led_in      # the episode in which each state of an initiation set led last
    cdef int64_t episode

    def __cinit__(self, Learner learner not None, plan):
        self.learner = learner
        self.draw, self.guide, self.note = plan.draw, plan.guide, plan.note
        self.led = {}
        self.led_in = None
        self.mixes = plan.mixing is not None
        if self.mixes:
            self.psi, self.decay = plan.mixing
            check_mixing(self.psi, self.decay)
        self.epsilon = learner.chance(plan.epsilon)
        # no step limit is as high as the longest patience
        self.patience = LONGEST_PATIENCE if plan.patience is None else plan.patience
        self.growth = plan.growth

    cdef list run_episode(self, uint32_t start):
        """Run an episode and return the candidates drawn; the same as `Plan.run`."""
        cdef Learner learner = self.learner
        cdef double patience = self.patience
        cdef int64_t budget
        cdef list drawn = []
        cdef Led led
        learner.enter(start)
        self.episode += 1
        while True:
            led = self.next_guide(drawn)
            patience = min(patience, LONGEST_PATIENCE)
            budget = max(1, <int64_t>rint(patience))
            if led is not None:
                self.lead(led)
                if led.initiation is not None:
                    self.explore_led(led, budget)
            learner.run_greedily(budget, self.epsilon)
            if learner.here == learner.goal or learner.taken >= learner.max_steps:
                break
            patience *= self.growth
        if self.note is not None:
            self.note(drawn, learner.taken, learner.here == learner.goal)
        return drawn

    cdef Led next_guide(self, list drawn):
        """Draw a candidate, and return what leads now."""
        cdef Led led
        if self.draw is None:
            return None
        candidate = checked_index("a candidate drawn", self.draw(), CANDIDATES)
        drawn.append(candidate)
        guide = None if self.guide is None else self.guide(candidate)
        if guide is None:
            return None
        led = self.led.get(candidate)
        if led is None or led.guide is not guide:
            led = self.led[candidate] = Led(guide, self.learner.dynamics.n_states)
        return led

    cdef int lead(self, Led led) except -1:
        if not self.mixes:
            return self.learner.run_policy(&led.policy[0], led.subgoal, self.learner.dynamics.n_states)
        return self.learner.run_reuse(&led.policy[0], led.subgoal, self.psi, self.decay)

    cdef int explore_led(self, Led led, int64_t budget) except -1:
        """Explore, led again from states of the initiation set that know nothing and have not led in this episode."""
        cdef Learner learner = self.learner
        cdef uint32_t state
        if self.led_in is None:
            self.led_in = np.zeros(learner.dynamics.n_states, dtype=np.int64)
        while learner.here != learner.goal and learner.taken < learner.max_steps:
            state = learner.here
            if led.initiation[state] and self.led_in[state] != self.episode and learner.greedy[state] == ALL_ACTIONS:
                self.led_in[state] = self.episode
                self.lead(led)
                continue
            if budget == 0:
                return 0
            learner.run_greedily(1, self.epsilon)
            budget -= 1
        return 0


def run_episodes(Learner learner not None, plan, start, int episodes, int trajectories):
    """Run all episodes of a task.

    Parameters
    ----------
    learner : Learner
    plan : ptl.agent.plan.Plan
    start : int
    episodes : int
    trajectories : int
        Paths wanted, those of the first successful episodes.

    Returns
    -------
    steps : int64 array, shape (episodes,)
    truncated : bool array, shape (episodes,)
        Whether the episode ran into the step limit.
    drawn : list of lists of int
        Candidates drawn in each episode.
    paths : list of int32 arrays
        Loop-erased paths as states, from the start to the goal.

    Raises
    ------
    ValueError
        If the plan draws or hands out what is none of a candidate, policy, subgoal and initiation set, or if the start
        is not a state.
    """
    learner.admit()
    cdef Run run = Run(learner, plan)
    cdef int n = learner.dynamics.n_states, episode, length, i
    cdef uint32_t first = <uint32_t>checked_index("start", start, n)
    lengths, cut_short = np.empty(episodes, dtype=np.int64), np.empty(episodes, dtype=bool)
    cdef int64_t[::1] steps = lengths
    cdef uint8_t[::1] truncated = cut_short.view(np.uint8)
    cdef uint32_t[::1] path = np.empty(n, dtype=np.uint32)
    cdef int32_t[::1] kept
    cdef list drawn = [], paths = []
    for episode in range(episodes):
        learner.episodes += 1
        drawn.append(run.run_episode(first))
        steps[episode] = learner.taken
        truncated[episode] = learner.here != learner.goal
        if learner.here == learner.goal and len(paths) < trajectories:
            length = learner.erase_loops(&path[0])
            kept = np.empty(length + 1, dtype=np.int32)
            for i in range(length + 1):
                kept[i] = path[i]
            paths.append(kept.base)
    return lengths, cut_short, drawn, paths

