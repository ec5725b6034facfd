# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""Subgoals of very many short tasks: the loop over tasks and the FD metric around the episode kernel.

`subgoals_from` simulates every step, and does for each goal what `ptl.learning.life` and `ptl.agent.subgoals.fd_metric`
do for one (tests hold them together). `Survey` draws from the same law with a small part of the steps: what a walk does
where nothing is known matters only for its loop-erased path, which Wilson's algorithm draws for all starts together.
The argument is in docs/performance.md.
"""

cimport cython
from cpython.exc cimport PyErr_CheckSignals
from cpython.number cimport PyNumber_Index
from libc.stdint cimport int32_t, int64_t, uint8_t, uint32_t, uint64_t
from libc.stdlib cimport calloc, free, malloc
from libc.string cimport memcpy, memset

import numpy as np

from ptl.agent._kernel cimport GREEDY_SLOTS, SLOTS, Dynamics, Learner, approach, direction_of

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

cdef enum:
    NONE = 255                 # no action of a tree is waiting in this state
    STEPS_UNWATCHED = 1 << 26  # steps between two looks for an interrupt, a fraction of a second
    TASK_GIVEN_UP = -2
    OUT_OF_MEMORY = -3

cdef int64_t NO_LIMIT = <int64_t>1 << 62
cdef uint32_t NO_STATE = <uint32_t>-1

NO_SUBGOAL, GIVEN_UP = -1, TASK_GIVEN_UP
"""Instead of a subgoal: the metric is 0 everywhere (adjacent cells); the task was given up."""


@cython.final
cdef class Metric:
    """Frequency times distance of the states on the loop-erased paths of one task."""

    cdef object _keep
    cdef uint32_t* path
    cdef uint32_t* met
    cdef int32_t* visits
    cdef double* distance
    cdef int n_met, n_paths

    def __cinit__(self, int n_states):
        cdef uint32_t[::1] path = np.empty(n_states, dtype=np.uint32), met = np.empty(n_states, dtype=np.uint32)
        cdef int32_t[::1] visits = np.zeros(n_states, dtype=np.int32)
        cdef double[::1] distance = np.zeros(n_states)
        self._keep = (path.base, met.base, visits.base, distance.base)
        self.path, self.met, self.visits, self.distance = &path[0], &met[0], &visits[0], &distance[0]

    cdef void clear(self) noexcept nogil:
        cdef int i
        for i in range(self.n_met):
            self.visits[self.met[i]] = 0
            self.distance[self.met[i]] = 0
        self.n_met = self.n_paths = 0

    cdef void note_path(self, Learner learner) noexcept nogil:
        """Count the path of the learner's episode, which has reached the goal."""
        cdef int length = learner.erase_loops(self.path), j
        cdef uint32_t state
        for j in range(length + 1):
            state = self.path[j]
            if not self.visits[state]:
                self.met[self.n_met] = state
                self.n_met += 1
            self.visits[state] += 1
            self.distance[state] += 2.0 * min(j, length - j) / length
        self.n_paths += 1

    cdef int32_t best(self) noexcept nogil:
        """The first of the states with the highest metric, -1 if it is 0 everywhere."""
        cdef int32_t found = -1
        cdef double highest = 0.0, value
        cdef int32_t state
        cdef int i
        for i in range(self.n_met):
            state = self.met[i]
            value = (<double>self.visits[state] / self.n_paths) * (self.distance[state] / self.visits[state])
            if value > highest or (value == highest and value > 0 and state < found):
                found, highest = state, value
        return found


def subgoals_from(Dynamics dynamics not None, start, goals, bit_generator, trajectories, attempts, *,
                  alpha, gamma, epsilon, max_steps, shortcut=True, ties="random"):
    """The subgoal of the original FD metric for the tasks from one start to each of several goals, step by step.

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

    Raises
    ------
    ValueError
        If a number is out of its range.
    """
    cdef Learner learner = _Learner(dynamics, 0, bit_generator, alpha=alpha, gamma=gamma, epsilon=epsilon,
                                    max_steps=max_steps, shortcut=shortcut, ties=ties)
    learner.notes_pairs = False
    cdef int n = dynamics.n_states, episode, i, wanted = checked_count("trajectories", trajectories)
    cdef int most = checked_count("attempts", attempts)
    cdef uint32_t first = checked_state("start", start, n)
    cdef int64_t total_steps = 0
    cdef Metric metric = Metric(n)
    cdef uint32_t[::1] targets = checked_states("goals", goals, n, first)
    result = np.empty(len(targets), dtype=np.int32)
    cdef int32_t[::1] subgoals = result

    for i in range(targets.shape[0]):
        with nogil:
            learner.forget(targets[i])
            metric.clear()
            for episode in range(most):
                learner.enter(first)
                learner.run_greedily(NO_LIMIT, learner.epsilon)  # may raise, by a signal
                total_steps += learner.taken
                if learner.here == learner.goal:
                    metric.note_path(learner)
                    if metric.n_paths == wanted:
                        break
            subgoals[i] = metric.best() if metric.n_paths == wanted else TASK_GIVEN_UP
        PyErr_CheckSignals()
    return result, total_steps


@cython.final
cdef class Survey:
    """The tasks from many starts to one goal after another, with what walks do where nothing is known drawn as trees.

    Equal greedy actions tie at random, or such walks would not be uniform.
    Each task has the law of `subgoals_from` without a step limit; tasks with the same goal share trees and so are
    dependent. docs/performance.md gives the argument.

    Parameters
    ----------
    dynamics : Dynamics
        Every move can be taken back.
    trajectories : int
        T, episodes a task.
    alpha, gamma, epsilon : float
    max_steps : int
        Simulated steps after which an episode is given up, and with it its task. Most steps are not simulated, so
        this is no step limit of the episode, only a bound of the time that it may take.
    margin : int
        Steps, at least 1, by which the ball without trees is larger than what is known as an episode begins. The law
        does not depend on it.
    memory : int
        Bytes of trees beyond which they are drawn anew, before an episode begins.

    Raises
    ------
    ValueError
        If a move cannot be taken back or a number is out of its range.

    Attributes
    ----------
    steps, steps_of_trees : int
        Simulated steps so far, and the part of them that drew trees.
    held : int
        Bytes of the trees that are held.
    """

    cdef readonly int64_t steps, steps_of_trees, held
    cdef int64_t memory
    cdef Dynamics dynamics
    cdef Metric metric
    cdef object parameters, _keep
    cdef int n, trajectories, margin
    cdef uint32_t goal
    cdef int farthest           # greatest distance from the goal
    cdef uint32_t* distance     # of each state from the goal, in steps; NO_STATE if there is no way
    cdef uint32_t* order        # states from which there is a way, by distance
    cdef int n_reached
    cdef uint32_t* gate         # the last state that every way to the goal passes, the nearest to each state
    cdef uint32_t* closed       # successors, with moves behind a gate replaced by staying at it
    cdef uint32_t* jumps        # two-step successors of these
    cdef uint8_t* is_gate
    cdef uint32_t* stack
    cdef uint32_t* entered
    cdef uint32_t* lowest
    cdef uint32_t* parent
    cdef uint8_t* next_action
    cdef uint8_t* in_tree
    cdef uint8_t* waiting       # action of the tree for the first visit of a state in this episode, NONE if none
    cdef uint8_t*** trees       # by episode and radius up to the greatest distance, drawn when first needed
    cdef int n_grown            # episodes that have had a tree since trees were last felled
    cdef int informed_radius    # greatest distance of a state where Q is not zero
    cdef int radius             # of the tree of this episode
    cdef bint tree_holds, busy
    cdef uint32_t passed_gate   # the gate to which this episode was led by its tree

    def __cinit__(self, Dynamics dynamics not None, trajectories, *, alpha, gamma, epsilon, max_steps, margin=2,
                  memory=2**28):
        cdef int n = dynamics.n_states, s, a, b
        cdef uint32_t* successors = dynamics.successors
        for s in range(n):
            for a in range(4):
                for b in range(4):
                    if successors[4 * successors[4 * s + a] + b] == <uint32_t>s:
                        break
                else:
                    raise ValueError(f"the move from state {s} by action {a} cannot be taken back")
        self.n, self.dynamics = n, dynamics
        self.trajectories = checked_count("trajectories", trajectories)
        self.margin = checked_count("margin", margin)
        self.memory = memory
        self.parameters = dict(alpha=alpha, gamma=gamma, epsilon=epsilon, max_steps=max_steps)
        self.metric = Metric(n)
        words = np.zeros((8, n), dtype=np.uint32)
        rows = np.zeros((20, n), dtype=np.uint32)
        flags = np.zeros((4, n), dtype=np.uint8)
        self._keep = (words, rows, flags)
        cdef uint32_t[:, ::1] word = words, row = rows
        cdef uint8_t[:, ::1] flag = flags
        self.distance, self.order, self.gate, self.stack = &word[0, 0], &word[1, 0], &word[2, 0], &word[3, 0]
        self.entered, self.lowest, self.parent = &word[4, 0], &word[5, 0], &word[6, 0]
        self.jumps, self.closed = &row[0, 0], &row[16, 0]
        self.is_gate, self.next_action, self.in_tree = &flag[0, 0], &flag[1, 0], &flag[2, 0]
        self.waiting = &flag[3, 0]
        self.trees = <uint8_t***>calloc(self.trajectories, sizeof(void*))
        if self.trees == NULL:
            raise MemoryError

    def __dealloc__(self):
        if self.trees != NULL:
            self.fell_trees()
            free(self.trees)

    def subgoals_to(self, goal, starts, bit_generator):
        """The subgoal of the original FD metric for the task from each start to one goal.

        Parameters
        ----------
        goal : int
        starts : sequence of int
            Starts, each other than the goal, from which there is a way to it.
        bit_generator : numpy.random.BitGenerator
            Source of all randomness of these tasks.

        Returns
        -------
        int32 array, shape (len(starts),)
            Argmax of f * d; -1 if it is 0 everywhere (adjacent cells); -2 if the task was given up.

        Raises
        ------
        ValueError
            If a number is out of its range, or there is no way from a start to the goal.
        RuntimeError
            If a call is still going on, in another thread or below a signal handler.
        """
        if self.busy:
            raise RuntimeError("the survey is in the middle of another call; use it after that has returned")
        self.busy = True
        try:
            return self.all_subgoals_to(checked_state("goal", goal, self.n), starts, bit_generator)
        finally:
            self.busy = False

    cdef all_subgoals_to(self, uint32_t goal, starts, bit_generator):
        cdef int i
        cdef int64_t unwatched = self.steps
        cdef uint32_t[::1] given = checked_states("starts", starts, self.n, goal)
        result = np.empty(len(given), dtype=np.int32)
        cdef int32_t[::1] subgoals = result
        cdef Learner learner = _Learner(self.dynamics, goal, bit_generator, **self.parameters)
        learner.notes_pairs = False
        self.goal = goal
        self.fell_trees()
        self.measure_distances()
        for i in range(given.shape[0]):
            if self.distance[given[i]] == NO_STATE:
                raise ValueError(f"there is no way from start {given[i]} to goal {goal}")
        self.find_gates()
        self.close_gates(learner)
        for i in range(given.shape[0]):
            with nogil:
                subgoals[i] = self.subgoal_from(learner, given[i])
            if subgoals[i] == OUT_OF_MEMORY:
                raise MemoryError
            if self.steps - unwatched > STEPS_UNWATCHED:
                PyErr_CheckSignals()
                unwatched = self.steps
        return result

    # -- the map as seen from the goal ----------------------------------------------------------------------------

    cdef void measure_distances(self) noexcept:
        """Find distances to the goal, and the order by them."""
        cdef int head = 0, i
        cdef uint32_t state, before
        cdef uint32_t* first = self.dynamics.first_predecessor
        memset(self.distance, 255, self.n * sizeof(uint32_t))
        self.distance[self.goal] = 0
        self.order[0] = self.goal
        self.n_reached = 1
        while head < self.n_reached:
            state = self.order[head]
            head += 1
            for i in range(first[state], first[state + 1]):
                before = self.dynamics.predecessors[i]
                if self.distance[before] == NO_STATE:
                    self.distance[before] = self.distance[state] + 1
                    self.order[self.n_reached] = before
                    self.n_reached += 1
        self.farthest = self.distance[self.order[self.n_reached - 1]]

    cdef void find_gates(self) noexcept:
        """Find the gate of each state: the nearest state that all its ways to the goal pass, maybe the goal.

        Depth first from the goal (Hopcroft and Tarjan): a state separates a child and all below it from the goal if
        no edge leads from there to above the state.
        """
        cdef uint32_t state, other, above
        cdef uint32_t clock = 0
        cdef int depth = 0, i
        cdef uint32_t* successors = self.dynamics.successors
        memset(self.entered, 255, self.n * sizeof(uint32_t))
        memset(self.next_action, 0, self.n)
        self.stack[0] = self.goal
        self.parent[self.goal] = self.goal
        self.entered[self.goal] = self.lowest[self.goal] = clock
        while depth >= 0:
            state = self.stack[depth]
            if self.next_action[state] < 4:
                other = successors[4 * state + self.next_action[state]]
                self.next_action[state] += 1
                if self.entered[other] == NO_STATE:
                    clock += 1
                    self.entered[other] = self.lowest[other] = clock
                    self.parent[other] = state
                    depth += 1
                    self.stack[depth] = other
                elif self.entered[other] < self.lowest[state]:
                    self.lowest[state] = self.entered[other]
            else:
                depth -= 1
                above = self.parent[state]
                if self.lowest[state] < self.lowest[above]:
                    self.lowest[above] = self.lowest[state]
        # the states in the order of entering, now that the stack is empty
        for i in range(self.n):
            if self.entered[i] != NO_STATE:
                self.stack[self.entered[i]] = i
        self.gate[self.goal] = self.goal
        memset(self.is_gate, 0, self.n)
        for i in range(1, self.n_reached):
            state = self.stack[i]
            above = self.parent[state]
            if above == self.goal or self.lowest[state] >= self.entered[above]:
                self.gate[state] = above
                self.is_gate[above] = 1
            else:
                self.gate[state] = self.gate[above]
        self.is_gate[self.goal] = 0

    cdef void close_gates(self, Learner learner) noexcept:
        """Close all gates: moves behind them are replaced by staying, as what is behind leads back to them."""
        cdef int i, g
        cdef uint32_t state, action, after, middle
        for i in range(self.n_reached):
            state = self.order[i]
            for action in range(4):
                after = self.dynamics.successors[4 * state + action]
                if self.is_gate[state] and self.gate[after] == state:
                    after = state
                self.closed[4 * state + action] = after
            if self.is_gate[state]:
                self.close_gate(learner, state)
        for i in range(self.n_reached):
            state = self.order[i]
            for g in range(16):
                middle = self.closed[4 * state + (g & 3)]
                self.jumps[16 * state + g] = SLOTS * self.closed[4 * middle + (g >> 2)]

    cdef void close_gate(self, Learner learner, uint32_t state) noexcept nogil:
        """Let the learner's moves of a gate that knows nothing stay in front of it."""
        cdef uint32_t action
        for action in range(4):
            learner.moves[SLOTS * state + GREEDY_SLOTS + action] = SLOTS * self.closed[4 * state + action] + action
        learner.fill_moves(state)

    cdef void open_gate(self, Learner learner, uint32_t state) noexcept nogil:
        """Let the learner's moves of a gate lead behind it, because something will be known there."""
        cdef uint32_t action
        for action in range(4):
            learner.moves[SLOTS * state + GREEDY_SLOTS + action] = (
                SLOTS * self.dynamics.successors[4 * state + action] + action)
        learner.fill_moves(state)
        if state == self.passed_gate:
            self.drop_tree()

    # -- trees ----------------------------------------------------------------------------------------------------

    cdef uint8_t* tree(self, Learner learner, int episode, int radius, const uint8_t* whole) noexcept nogil:
        """The action of each state in the tree of an episode and a radius, NONE within the radius; NULL without memory.

        The whole tree is that of radius 0 (NULL to draw it).
        """
        cdef uint8_t** row = self.trees[episode]
        if row == NULL:
            row = <uint8_t**>calloc(self.farthest + 1, sizeof(void*))
            if row == NULL:
                return NULL
            self.trees[episode] = row
            self.held += (self.farthest + 1) * sizeof(void*)
            self.n_grown = max(self.n_grown, episode + 1)
        if row[radius] == NULL:
            row[radius] = <uint8_t*>malloc(self.n)
            if row[radius] == NULL:
                return NULL
            self.held += self.n
            self.draw_tree(learner, row[radius], whole, radius)
        return row[radius]

    cdef void fell_trees(self) noexcept nogil:
        cdef int episode, radius
        for episode in range(self.n_grown):
            if self.trees[episode] != NULL:
                for radius in range(self.farthest + 1):
                    free(self.trees[episode][radius])
                free(self.trees[episode])
                self.trees[episode] = NULL
        self.n_grown = 0
        self.held = 0

    cdef void draw_tree(self, Learner learner, uint8_t* tree, const uint8_t* whole, int radius) noexcept nogil:
        """Wilson's algorithm: from each state in turn, walk until the tree is met and keep the last exits.

        Gates are closed, which takes only loops away because states come in the order of their distance. The part
        behind a gate at the edge of the ball or beyond does not depend on the radius and is that of the whole tree.
        """
        cdef int i
        cdef uint32_t state, here, action
        cdef uint64_t word
        cdef int left = 0
        cdef int64_t steps = 0
        memset(tree, NONE, self.n)
        memset(self.in_tree, 0, self.n)
        for i in range(self.n_reached):
            state = self.order[i]
            if self.distance[state] <= <uint32_t>radius:
                self.in_tree[state] = 1
            elif radius > 0 and self.distance[self.gate[state]] >= <uint32_t>radius:
                self.in_tree[state] = 1
                tree[state] = whole[state]
        for i in range(self.n_reached):
            state = here = self.order[i]
            while not self.in_tree[here]:
                if left == 0:
                    if learner.next_word == 256:
                        learner.draw_words()
                    word = learner.words[learner.next_word]
                    learner.next_word += 1
                    left = 32
                action = word & 3
                word >>= 2
                left -= 1
                tree[here] = action
                here = self.closed[4 * here + action]
                steps += 1
            while not self.in_tree[state]:
                self.in_tree[state] = 1
                state = self.closed[4 * state + tree[state]]
        self.steps += steps
        self.steps_of_trees += steps

    cdef void drop_tree(self) noexcept nogil:
        """Draw every further action of this episode afresh."""
        if self.tree_holds:
            memset(self.waiting, NONE, self.n)
            self.tree_holds = False

    # -- tasks ----------------------------------------------------------------------------------------------------

    cdef int32_t subgoal_from(self, Learner learner, uint32_t start) noexcept nogil:
        cdef int i, episode
        cdef uint32_t state
        cdef uint8_t* whole
        cdef uint8_t* tree
        for i in range(learner.n_informed):
            state = learner.informed_states[i]
            if self.is_gate[state]:
                self.close_gate(learner, state)
        learner.forget(self.goal)
        self.metric.clear()
        self.informed_radius = 0
        for episode in range(self.trajectories):
            if self.held > self.memory:
                self.fell_trees()
            learner.enter(start)
            whole = self.tree(learner, episode, 0, NULL)
            if whole == NULL:
                return OUT_OF_MEMORY
            self.radius = self.informed_radius + self.margin if self.informed_radius else 0
            if self.radius < self.farthest:
                tree = self.tree(learner, episode, self.radius, whole)
                if tree == NULL:
                    return OUT_OF_MEMORY
                memcpy(self.waiting, tree, self.n)
                self.tree_holds = True
            else:
                memset(self.waiting, NONE, self.n)
                self.tree_holds = False

            # The way to the last gate that knows nothing is the tree's.
            self.passed_gate = NO_STATE
            state = self.gate[start]
            while state != self.goal and not learner.informed[state]:
                self.passed_gate = state
                state = self.gate[state]
            if self.passed_gate != NO_STATE:
                state = start
                while state != self.passed_gate:
                    learner.last_exit[state] = whole[state]
                    state = self.dynamics.successors[4 * state + whole[state]]
                    learner.taken += 1
                learner.here = state
            self.walk(learner)
            self.steps += learner.taken
            if learner.here != self.goal:
                return TASK_GIVEN_UP
            self.metric.note_path(learner)
        return self.metric.best()

    cdef void learn(self, Learner learner, uint32_t state, uint32_t action, double target) noexcept nogil:
        """An update that changes Q."""
        cdef bint known = learner.informed[state]
        if not known and self.is_gate[state]:
            self.open_gate(learner, state)
        approach(learner, learner.values, target, learner.alpha, state, action)
        if not known and <int>self.distance[state] > self.informed_radius:
            self.informed_radius = self.distance[state]
            if self.informed_radius >= self.radius:
                self.drop_tree()

    cdef void walk(self, Learner learner) noexcept nogil:
        """An episode from the learner's state to the goal, as in the kernel but for trees and closed gates."""
        cdef:
            uint32_t* moves = learner.moves
            uint32_t* jumps = self.jumps
            uint32_t* closed = self.closed
            uint32_t* successors = self.dynamics.successors
            double* values = learner.values
            double* target = learner.target
            uint8_t* cold = learner.cold
            uint8_t* last_exit = learner.last_exit
            uint8_t* waiting = self.waiting
            uint64_t epsilon = learner.epsilon
            uint32_t goal = self.goal, row = SLOTS * learner.here
            uint32_t half = 0
            bint has_half = False, slips = learner.slip > 0
            int64_t left = learner.max_steps - learner.taken
            uint32_t state, action, direction, middle, move, slot
            uint64_t word, product
            int group

        while row != SLOTS * goal and left > 0:
            state = row // SLOTS
            if waiting[state] != NONE:
                direction = waiting[state]
                waiting[state] = NONE
                last_exit[state] = direction
                move = successors[4 * state + direction]
                if target[move] != 0:
                    # trees give directions: that of a uniform action, or a slip
                    action = direction_of(learner, direction)
                    self.learn(learner, state, action, target[move])
                row = SLOTS * move
                left -= 1
            elif cold[state]:
                if learner.next_word == 256:
                    learner.draw_words()
                word = learner.words[learner.next_word]
                learner.next_word += 1
                for group in range(16):
                    slot = word & 15
                    word >>= 4
                    direction = slot & 3
                    middle = closed[row // 4 + direction]
                    last_exit[state] = direction
                    if waiting[middle] != NONE:
                        row = SLOTS * middle
                        left -= 1
                        break
                    last_exit[middle] = slot >> 2
                    row = jumps[row + slot]
                    state = row // SLOTS
                    left -= 2
                    if not cold[state] or waiting[state] != NONE:
                        break
            else:
                if has_half:
                    product = <uint64_t>half * GREEDY_SLOTS
                    has_half = False
                else:
                    if learner.next_word == 256:
                        learner.draw_words()
                    word = learner.words[learner.next_word]
                    learner.next_word += 1
                    product = <uint64_t><uint32_t>word * GREEDY_SLOTS
                    half = word >> 32
                    has_half = True
                slot = product >> 32
                if <uint32_t>product < epsilon:
                    slot = GREEDY_SLOTS + (slot & 3)
                move = moves[row + slot]
                action = direction = move % SLOTS
                if slips:
                    direction = direction_of(learner, action)
                    move = moves[row + GREEDY_SLOTS + direction]
                last_exit[state] = direction
                if values[row // 4 + action] != target[move // SLOTS]:
                    self.learn(learner, state, action, target[move // SLOTS])
                row = move - direction
                left -= 1
        learner.here = row // SLOTS
        learner.taken = learner.max_steps - left


cdef uint32_t checked_state(name, value, int64_t n_states) except? 0xFFFFFFFF:
    """A state, or ValueError naming the argument."""
    cdef int64_t number
    try:
        number = PyNumber_Index(value)
    except (TypeError, OverflowError):
        number = -1
    if not 0 <= number < n_states:
        raise ValueError(f"{name} must be a whole number from 0 to {n_states - 1}, not {value!r}")
    return <uint32_t>number


cdef int checked_count(name, value) except -1:
    """A positive number, or ValueError naming the argument."""
    cdef int64_t number
    try:
        number = PyNumber_Index(value)
    except (TypeError, OverflowError):
        number = 0
    if not 1 <= number <= 10**7:
        raise ValueError(f"{name} must be a whole number from 1 to {10**7}, not {value!r}")
    return <int>number


def checked_states(name, values, n_states, other):
    """Return states other than one as a uint32 array (k,), or raise ValueError naming the argument."""
    states = np.array(values)
    if states.ndim != 1 or (states.size and states.dtype.kind not in "iu"):
        raise ValueError(f"{name} must be a sequence of states")
    if states.size and not (0 <= states.min() and states.max() < n_states):
        raise ValueError(f"{name} must be whole numbers from 0 to {n_states - 1}")
    if (states == other).any():
        raise ValueError("start and goals must be different states")
    return states.astype(np.uint32)
