# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
# cython: embedsignature=True
"""The hot loop: episodes of tabular Q-learning in a world of one step in each direction, which may slip.

One `Learner` learns one task (one goal). Between `begin_episode` and the goal its four calls can follow each other in
any order, which is all that the methods are made of:

``explore``   act epsilon-greedily on the task's Q, with a bonus or a mask if wanted,
``follow``    follow a stored policy to its subgoal (PTL's skills),
``reuse``     pi-reuse of a past policy (Fernandez and Veloso),
``act``       take one action, drawn by `choose` or chosen elsewhere.

Every primitive step, whoever chose it, updates Q(s,a) += alpha (r + gamma max_b Q(s',b) - Q(s,a)), with r = 1 and no
bootstrap at the goal and r = 0 elsewhere, and notes its direction as the last exit from s and as taken in s. In a
world that slips the direction is, with the probability of slipping, drawn uniformly from the four, and otherwise that of
the action; Q is updated for the action. A method with another update takes its steps by ``act(action, learn=False)`` and
changes Q by `update`, `set_value` and `set_q`.

How it is fast
--------------
*Table of targets.* gamma max_b Q(s,b) is kept for each state, and 1 for the goal, which is all that the update of a
step into the state needs to know.

*Table of moves.* Twelve slots a state hold the greedy moves, each tied action in 12/k of them (or the first in all), and
four more hold the four actions. A draw r of 32 bits gives p = 12 r: the high half of p is a slot (0..11) and the low half decides between
the greedy slots and the uniform ones, so that the index of a move does not depend on the state and a step is one load.

*Two steps at a time where nothing is known.* Call a state cold if Q has been zero since the task began on all states
within two steps of it and the goal is none of them. There all four actions tie, so the next two actions are uniform and
independent whatever epsilon is, and so are the next two directions whether steps slip or not; both targets are
gamma * 0, so the two updates leave Q as it is, whichever actions they are for; and the episode cannot end. Two steps are
therefore four random bits and one load from a table of two-step successors. The law of the episode is that of single
steps, and `ptl.agent.reference`, which takes these steps singly and with all updates, agrees bit for bit. Both last exits
are noted as ever, and the two directions as one pair.

*Slipping costs nothing where nothing slips.* The loop of single steps is compiled twice, with and without it.

Floating point is plain IEEE double without contraction: the same bits on every machine.

What Python hands over is copied and checked before use, because the loops do not check again.
"""

cimport cython
from cpython.exc cimport PyErr_CheckSignals
from cpython.number cimport PyNumber_Index
from cpython.pycapsule cimport PyCapsule_GetPointer
from libc.math cimport fabs
from libc.stdint cimport int32_t, int64_t, uint8_t, uint32_t, uint64_t
from libc.string cimport memset
from numpy.random cimport bitgen_t

import numpy as np

cdef extern from "pythread.h":
    unsigned long PyThread_get_thread_ident() nogil

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
    WORDS = 256      # random words drawn at a time

MOST_STATES = 2**32 // SLOTS  # so that an offset into the table of moves fits 32 bits
NO_LIMIT = <int64_t>1 << 62
NO_STATE = <uint32_t>-1
cdef int64_t CHECK_EVERY = <int64_t>1 << 24  # steps between looks at signals such as Ctrl-C, a fraction of a second
cdef double TWO_32 = 4294967296.0
cdef double LARGEST = 1e300  # bound of |Q| and of bonuses: no sum or difference of two of them overflows

# The action in each greedy slot for every set of tied actions (bit a: action a), in the order of the actions.
cdef uint8_t[16][12] TIED_ACTION
cdef int _set, _slot
for _set in range(1, 16):
    _tied = [a for a in range(4) if _set >> a & 1]
    for _slot in range(GREEDY_SLOTS):
        TIED_ACTION[_set][_slot] = _tied[_slot * len(_tied) // GREEDY_SLOTS]


@cython.final
cdef class Dynamics:
    """The transitions of one map in the layout of the kernel; shared by all learners on the map.

    Parameters
    ----------
    successors : int array, shape (n_states, 4)
        State after a step in each direction (north, south, west, east).
    slip : float
        Probability that the direction of a step is drawn uniformly from the four, whatever the action.

    Raises
    ------
    ValueError
        If the shape is wrong, a successor is not a state or the slip no probability.
    """

    def __cinit__(self, successors, slip=0.0):
        self.slip = check_probability("slip", slip)
        given = np.array(successors)
        if given.ndim != 2 or given.shape[1] != 4 or not len(given):
            raise ValueError("successors must have the shape (n_states, 4)")
        if given.dtype.kind not in "iu" or given.min() < 0 or given.max() >= len(given):
            raise ValueError("a successor is not a state")
        if len(given) > MOST_STATES:
            raise ValueError(f"the kernel holds {MOST_STATES:,} states at most, not {len(given):,}")
        table = np.array(given, dtype=np.uint32, order="C")
        self.n_states = len(table)
        # Entry g of a state's row: the state after action g & 3 and then action g >> 2, as an offset into the moves.
        after_two = table[table].transpose(0, 2, 1).reshape(-1, 16)
        jumps = np.ascontiguousarray(after_two * np.uint32(SLOTS), dtype=np.uint32)
        order = np.argsort(table.ravel(), kind="stable")
        predecessors = (order // 4).astype(np.uint32)
        bounds = np.searchsorted(table.ravel()[order], np.arange(self.n_states + 1)).astype(np.uint32)
        # The moves of a state that knows nothing: all four actions tie.
        actions = [TIED_ACTION[ALL_ACTIONS][slot] for slot in range(GREEDY_SLOTS)] + [0, 1, 2, 3]
        self.fresh_moves = table[:, actions] * np.uint32(SLOTS) + np.array(actions, dtype=np.uint32)
        self._keep = (table, jumps, predecessors, bounds)
        self.successors = pointer32(table)
        self.jumps = pointer32(jumps)
        self.predecessors = pointer32(predecessors)
        self.first_predecessor = pointer32(bounds)


cdef uint32_t* pointer32(array):
    cdef uint32_t[::1] view = array.reshape(-1)
    return &view[0]


cdef uint8_t* pointer8(array):
    cdef uint8_t[::1] view = array.reshape(-1)
    return &view[0]


cdef double* pointer_double(array):
    cdef double[::1] view = array.reshape(-1)
    return &view[0]


cdef uint64_t threshold(double probability) noexcept nogil:
    """The number of 32-bit draws out of 2**32 that stand for a probability."""
    return <uint64_t>(probability * TWO_32)


cdef inline uint32_t draw(Learner learner) noexcept nogil:
    """The next 32 random bits: the low half of a word, then its high half."""
    if learner.has_half:
        learner.has_half = False
        return learner.half
    if learner.next_word == WORDS:
        learner.draw_words()
    learner.half = learner.words[learner.next_word] >> 32
    learner.has_half = True
    learner.next_word += 1
    return <uint32_t>learner.words[learner.next_word - 1]


cdef uint32_t slipped(Learner learner, uint32_t action) noexcept nogil:
    """The direction of a step that may slip, from the next 32 random bits."""
    cdef uint64_t product = <uint64_t>draw(learner) * 4
    return <uint32_t>(product >> 32) if <uint32_t>product < learner.slip else action


cdef inline uint32_t epsilon_greedy(Learner learner, uint64_t epsilon) noexcept nogil:
    """The epsilon-greedy action of the present state, from the next 32 random bits."""
    cdef uint64_t product = <uint64_t>draw(learner) * GREEDY_SLOTS
    cdef uint32_t slot = product >> 32
    if <uint32_t>product < epsilon:
        slot = GREEDY_SLOTS + (slot & 3)
    return learner.moves[SLOTS * learner.here + slot] % SLOTS


cdef inline uint32_t biased_greedy(Learner learner, uint64_t epsilon, const double* bonus, uint8_t mask) noexcept nogil:
    """The action of the present state that is epsilon-greedy over Q + bonus (NULL for none) among a set of actions."""
    cdef uint64_t product = <uint64_t>draw(learner) * GREEDY_SLOTS
    cdef uint32_t slot = product >> 32, action
    cdef double best = -3 * LARGEST, value
    cdef uint8_t greedy = 0
    if <uint32_t>product < epsilon:
        # with all actions allowed the same action as in `epsilon_greedy`
        return slot & 3 if mask == ALL_ACTIONS else TIED_ACTION[mask][slot]
    for action in range(4):
        if mask >> action & 1:
            value = learner.values[4 * learner.here + action]
            if bonus != NULL:
                value += bonus[action]
            if value > best:
                best = value
                greedy = 0
            if value == best:
                greedy |= 1 << action
    return greedy_action(learner, greedy, slot)


cdef inline uint32_t greedy_action(Learner learner, uint8_t greedy, uint32_t slot) noexcept nogil:
    """The action of a slot for a set of greedy actions; the first one of the set if ties go to it."""
    return TIED_ACTION[greedy][0 if learner.first_of_ties else slot]


cdef inline void step(Learner learner, uint32_t action) noexcept nogil:
    """One primitive step of the agent with its update."""
    cdef uint32_t state = learner.here
    move(learner, direction_of(learner, action))
    update(learner, learner.values, learner.target, learner.alpha, state, action, learner.here)


cdef inline void move(Learner learner, uint32_t direction) noexcept nogil:
    """One primitive step of the agent in a direction that leaves Q as it is."""
    cdef uint32_t state = learner.here
    if learner.taken < learner.record_limit:
        learner.directions[learner.taken] = direction
    learner.last_exit[state] = direction
    learner.taken_actions[4 * state + direction] = 1
    learner.here = learner.dynamics.successors[4 * state + direction]
    learner.taken += 1
    learner.until_check -= 1


cdef inline int64_t walk_on(Learner learner, int64_t left, int64_t pause, uint64_t epsilon,
                            bint slips) noexcept nogil:
    """`Learner.walk`, compiled once for each value of ``slips``."""
    # A state appears as its row, its offset SLOTS * state into the tables, so that a step is one load.
    cdef:
        uint32_t* moves = learner.moves
        uint32_t* jumps = learner.dynamics.jumps
        uint32_t* successors = learner.dynamics.successors
        double* values = learner.values
        double* target = learner.target
        uint8_t* cold = learner.cold
        uint8_t* taken_actions = learner.taken_actions
        uint8_t* taken_pairs = learner.taken_pairs
        uint8_t* last_exit = learner.last_exit
        double alpha = learner.alpha
        uint32_t goal = learner.goal, row = SLOTS * learner.here, half = learner.half
        bint has_half = learner.has_half, notes_pairs = learner.notes_pairs
        int64_t before = left
        uint32_t state, action, direction, middle, move, slot
        uint64_t word, product, slip = 0, chance = learner.slip
        int group, groups

    while left > pause and row != SLOTS * goal:
        state = row // SLOTS
        if left >= 2 and cold[state]:
            if learner.next_word == WORDS:
                learner.draw_words()
            word = learner.words[learner.next_word]
            learner.next_word += 1
            groups = <int>min(16, left // 2)
            for group in range(groups):
                slot = word & 15
                word >>= 4
                direction = slot & 3
                middle = successors[row // 4 + direction]
                last_exit[state] = direction
                last_exit[middle] = slot >> 2
                if notes_pairs:
                    taken_pairs[row + slot] = 1
                row = jumps[row + slot]
                state = row // SLOTS
                left -= 2
                if not cold[state]:
                    break
            continue

        if has_half and not slips:
            product = <uint64_t>half * GREEDY_SLOTS
            has_half = False
        else:
            if learner.next_word == WORDS:
                learner.draw_words()
            word = learner.words[learner.next_word]
            learner.next_word += 1
            if not slips:
                product = <uint64_t><uint32_t>word * GREEDY_SLOTS
                half = word >> 32
                has_half = True
            elif has_half:  # two draws: the half that is left and the low half of this word
                product = <uint64_t>half * GREEDY_SLOTS
                slip = <uint64_t><uint32_t>word * 4
                half = word >> 32
            else:
                product = <uint64_t><uint32_t>word * GREEDY_SLOTS
                slip = (word >> 32) * 4
        slot = product >> 32
        if <uint32_t>product < epsilon:
            slot = GREEDY_SLOTS + (slot & 3)
        move = moves[row + slot]
        action = direction = move % SLOTS
        if slips:  # the direction's slot is known before the action is, so that neither load waits for the other
            if <uint32_t>slip < chance:
                slot = GREEDY_SLOTS + <uint32_t>(slip >> 32)
            move = moves[row + slot]
            direction = move % SLOTS
        last_exit[state] = direction
        taken_actions[row // 4 + direction] = 1
        update(learner, values, target, alpha, state, action, move // SLOTS)
        row = move - direction
        left -= 1

    learner.here = row // SLOTS
    learner.half, learner.has_half = half, has_half
    learner.taken += before - left
    learner.until_check -= before - left
    return left


@cython.final
cdef class Learner:
    """Learns one task in one world, episode by episode.

    Parameters
    ----------
    dynamics : Dynamics
    goal : int
        State at which an episode ends with reward 1.
    bit_generator : numpy.random.BitGenerator
        Source of all randomness; its 64-bit words are used in order. They are read ahead in blocks, so nothing else
        should draw from the same generator.
    alpha, gamma : float
        Learning rate and discount.
    epsilon : float
        Probability of a uniformly random action in `explore`.
    max_steps : int
        Steps after which an episode is truncated.
    initial_q : float array, shape (n_states, 4), optional
        Starts from these values instead of zero.
    shortcut : bool
        Take two steps at a time where Q is zero all around; the law is the same without. Not if the first of equal
        actions is taken, which makes another law.
    ties : {"random", "first"}
        Which of equal greedy actions is taken: any, or the first in the order north, south, west, east.

    Raises
    ------
    ValueError
        If an argument of this or of any other call is out of its range; a state, an action and a number of steps must
        be whole numbers, values finite and at most 1e300 in size.
    RuntimeError
        If another thread than the one that made the learner uses it, or a signal handler that has interrupted it.
    """

    def __cinit__(self, Dynamics dynamics not None, goal, bit_generator, *, alpha=0.05, gamma=0.95, epsilon=0.1,
                  max_steps=10**7, initial_q=None, shortcut=True, ties="random"):
        cdef int n = dynamics.n_states, state
        goal = checked_index("goal", goal, n)
        check_probability("alpha", alpha)
        check_probability("gamma", gamma)
        max_steps = checked_index("max_steps", max_steps, NO_LIMIT)
        if max_steps < 1:
            raise ValueError(f"max_steps must be at least 1, not {max_steps}")
        self.dynamics = dynamics
        self.alpha, self.gamma = alpha, gamma
        self.epsilon = threshold(check_probability("epsilon", epsilon))
        self.slip = threshold(dynamics.slip)
        self.max_steps = max_steps
        if ties not in ("random", "first"):
            raise ValueError(f"ties must be 'random' or 'first', not {ties!r}")
        self.first_of_ties = ties == "first"
        self.shortcut = shortcut and not self.first_of_ties
        self.notes_pairs = True
        if not isinstance(bit_generator, np.random.BitGenerator):
            raise ValueError(f"bit_generator must be a numpy.random.BitGenerator, not {bit_generator!r}")
        # the capsule of the class itself: that of a subclass in Python may belong to an object that is gone
        capsule = np.random.BitGenerator.capsule.__get__(bit_generator)
        self._generator = (bit_generator, capsule)
        self.generator = <bitgen_t*>PyCapsule_GetPointer(capsule, "BitGenerator")
        if self.generator.next_uint64 == NULL:
            raise ValueError(f"bit_generator draws no 64-bit words: {bit_generator!r}")
        self.next_word = WORDS
        self.until_check = CHECK_EVERY
        self.thread = PyThread_get_thread_ident()

        values = np.zeros((n, 4))
        best, target, greedy = np.zeros(n), np.zeros(n), np.full(n, ALL_ACTIONS, dtype=np.uint8)
        moves = dynamics.fresh_moves.copy()
        cold, informed = np.empty(n, dtype=np.uint8), np.zeros(n, dtype=np.uint8)
        taken_actions, taken_pairs = np.zeros((n, 4), dtype=np.uint8), np.zeros((n, 16), dtype=np.uint8)
        last_exit = np.zeros(n, dtype=np.uint8)
        informed_states = np.empty(n, dtype=np.uint32)
        self._keep = (values, best, target, greedy, moves, cold, informed, taken_actions, taken_pairs, last_exit,
                      informed_states)
        self.values, self.best, self.target = pointer_double(values), pointer_double(best), pointer_double(target)
        self.greedy, self.moves = pointer8(greedy), pointer32(moves)
        self.cold, self.informed = pointer8(cold), pointer8(informed)
        self.taken_actions, self.taken_pairs = pointer8(taken_actions), pointer8(taken_pairs)
        self.last_exit = pointer8(last_exit)
        self.informed_states = pointer32(informed_states)

        if self.first_of_ties:
            for state in range(n):
                self.fill_moves(state)
        self.record(0)
        self.n_informed = 0
        self.forget(goal)
        if initial_q is not None:
            self.fill_values(checked_values("initial_q", initial_q, (n, 4)))
        self.enter(goal)

    # -- what the methods call ----------------------------------------------------------------------------------

    def begin_episode(self, start):
        """Put the agent on a state and its step count to zero."""
        self.admit()
        self.enter(checked_index("start", start, self.dynamics.n_states))
        self.episodes += 1

    def explore(self, budget=None, epsilon=None, *, bonus=None, mask=None):
        """Act epsilon-greedily until the goal, the episode's step limit, or ``budget`` primitive steps from here.

        Parameters
        ----------
        budget : int, optional
        epsilon : float, optional
            Instead of the learner's.
        bonus : float array, shape (n_states, 4), optional
            Added to Q when the greedy action is chosen, not when Q is updated.
        mask : bool array, shape (n_states, 4), optional
            Allowed actions, at least one in each state; greedy and random actions are drawn among them.
        """
        self.admit()
        cdef int64_t limit = checked_budget(budget)
        cdef uint64_t chance = self.chance(epsilon)
        cdef const double[:, ::1] added
        cdef const uint8_t[::1] allowed
        cdef int n = self.dynamics.n_states
        if bonus is None and mask is None:
            self.run_greedily(limit, chance)
        else:
            added = np.zeros((n, 4)) if bonus is None else checked_values("bonus", bonus, (n, 4))
            allowed = np.full(n, ALL_ACTIONS, dtype=np.uint8) if mask is None else checked_mask(mask, (n, 4))
            self.run_biased(limit, chance, &added[0, 0], &allowed[0])

    def choose(self, epsilon=None, *, bonus=None, mask=None):
        """Return an epsilon-greedy action of the present state without taking it; the options are as in `explore`.

        Parameters
        ----------
        epsilon : float, optional
            Instead of the learner's.
        bonus : float array, shape (4,), optional
        mask : bool array, shape (4,), optional
        """
        self.admit()
        cdef uint64_t chance = self.chance(epsilon)
        cdef const double[::1] added
        cdef const uint8_t[::1] allowed
        cdef uint8_t actions = ALL_ACTIONS
        if mask is not None:
            allowed = checked_mask(mask, (4,))
            actions = allowed[0]
        if bonus is None:
            return biased_greedy(self, chance, NULL, actions)
        added = checked_values("bonus", bonus, (4,))
        return biased_greedy(self, chance, &added[0], actions)

    def act(self, action, *, learn=True):
        """Take one action and return the state that the step leads to.

        Parameters
        ----------
        action : int
            0 to 3 for north, south, west, east.
        learn : bool
            Whether Q-learning's update is made; without it Q stays as it is, for methods with their own update.

        Raises
        ------
        ValueError
            At the goal or at the episode's step limit, or if the action is no whole number from 0 to 3.
        """
        self.admit()
        cdef uint32_t chosen = <uint32_t>checked_index("action", action, 4)
        if self.here == self.goal:
            raise ValueError("the episode has ended at the goal; begin another one before acting")
        if self.taken >= self.max_steps:
            raise ValueError(f"the episode has reached its limit of {self.max_steps} steps; begin another one")
        if learn:
            step(self, chosen)
        else:
            move(self, direction_of(self, chosen))
        return self.here

    def follow(self, policy, subgoal=None, budget=None):
        """Follow a policy until its subgoal, a state where it is undefined, or an end as in `explore`.

        Parameters
        ----------
        policy : int8 array, shape (n_states,)
            Action of each state, -1 where undefined.
        subgoal : int, optional
            State that ends the guidance.
        budget : int, optional
            Without it a policy that leads into a wall or in a circle uses up the episode.
        """
        self.admit()
        cdef const signed char[::1] actions = checked_policy(policy, self.dynamics.n_states)
        cdef uint32_t last = checked_subgoal(subgoal, self.dynamics.n_states)
        self.run_policy(&actions[0], last, checked_budget(budget))

    def reuse(self, policy, double psi=1.0, double decay=0.95, *, subgoal=None):
        """Pi-reuse until the goal or the episode's step limit (Fernandez and Veloso).

        In step h the past policy is followed with probability psi_h; otherwise, and where it is undefined (our
        choice), the new policy acts, greedily with probability 1 - psi_h and at random with psi_h. Once psi_h has
        vanished the new policy acts greedily, or, with a subgoal, the call ends.

        Parameters
        ----------
        policy : int8 array, shape (n_states,)
            Action of the past policy in each state, -1 where it says nothing.
        psi, decay : float
            psi_1, and the factor from psi_h to psi_{h+1}.
        subgoal : int, optional
            State that ends the reuse.
        """
        self.admit()
        cdef const signed char[::1] actions = checked_policy(policy, self.dynamics.n_states)
        cdef uint32_t last = checked_subgoal(subgoal, self.dynamics.n_states)
        check_mixing(psi, decay)
        self.run_reuse(&actions[0], last, psi, decay)

    def record(self, limit):
        """Note the first ``limit`` directions of this and every later episode; 0 ends it. Steps then take longer.

        Raises
        ------
        ValueError
            If the limit is negative or the episode has begun.
        """
        self.admit()
        limit = checked_index("limit", limit, NO_LIMIT)
        recorded = np.empty(max(limit, 1), dtype=np.uint8)
        if self.taken:
            raise ValueError(f"recording must begin before the first step of an episode, not after {self.taken}")
        self.directions = pointer8(recorded)
        self.record_limit = limit
        self._recorded = recorded

    # -- what a method with its own update calls ----------------------------------------------------------------

    def update(self, state, action, target):
        """Move an action value towards a target, Q(s,a) += alpha (target - Q(s,a))."""
        self.admit()
        cdef uint32_t row = checked_index("state", state, self.dynamics.n_states)
        approach(self, self.values, checked_value(target), self.alpha, row, checked_index("action", action, 4))

    def set_value(self, state, action, value):
        """Set an action value."""
        self.admit()
        cdef uint32_t row = checked_index("state", state, self.dynamics.n_states)
        self.values[4 * row + checked_index("action", action, 4)] = checked_value(value)
        self.refresh(row)

    def set_q(self, q):
        """Set all action values, float array (n_states, 4); they are copied."""
        self.admit()
        self.fill_values(checked_values("q", q, (self.dynamics.n_states, 4)))

    # -- what can be asked --------------------------------------------------------------------------------------

    @property
    def state(self):
        """State of the agent."""
        return self.here

    @property
    def steps(self):
        """Primitive steps of this episode so far."""
        return self.taken

    @property
    def at_goal(self):
        """Whether the episode has ended at the goal."""
        return self.here == self.goal

    @property
    def truncated(self):
        """Whether the episode has run into its step limit before the goal."""
        return self.here != self.goal and self.taken >= self.max_steps

    @property
    def q(self):
        """Read-only copy of the action values, float64 array (n_states, 4); `set_q` changes them."""
        values = self._keep[0].copy()
        values.flags.writeable = False
        return values

    def value(self, state, action):
        """Return one action value."""
        cdef uint32_t row = checked_index("state", state, self.dynamics.n_states)
        return self.values[4 * row + checked_index("action", action, 4)]

    def values_of(self, state):
        """Return the four action values of a state as a tuple."""
        cdef double* row = &self.values[4 * <uint32_t>checked_index("state", state, self.dynamics.n_states)]
        return row[0], row[1], row[2], row[3]

    @property
    def seen(self):
        """Directions of this task's steps, uint8 array (n_states,), bit d set if one led in direction d.

        So these are the transitions that the agent has seen. Without slip they are the actions taken.
        """
        cdef int state, action, n = self.dynamics.n_states
        cdef uint8_t second
        cdef const uint8_t* pairs
        result = np.zeros(n, dtype=np.uint8)
        cdef uint8_t[::1] seen = result
        for state in range(n):
            # Steps taken two at a time are noted as pairs: action g & 3 in the state, then g >> 2 where it led.
            pairs = &self.taken_pairs[16 * state]
            for action in range(4):
                second = pairs[action] | pairs[action + 4] << 1 | pairs[action + 8] << 2 | pairs[action + 12] << 3
                seen[state] |= (self.taken_actions[4 * state + action] | (second != 0)) << action
                if second:
                    seen[self.dynamics.successors[4 * state + action]] |= second
        return result

    @property
    def transitions(self):
        """Transitions seen in this task: the state after a step in each direction, int32 (n_states, 4), -1 if unseen."""
        steps = np.unpackbits(self.seen[:, None], axis=1, count=4, bitorder="little")
        return np.where(steps, self.dynamics._keep[0], -1).astype(np.int32)

    @property
    def recorded(self):
        """First directions of this episode, uint8 array (min(steps, limit),); `record` sets the limit, 0 at first."""
        return self._recorded[: min(self.taken, self.record_limit)].copy()

    def erased_path(self):
        """States of this episode's path from its start to the present state, loops erased; int32 array (l + 1,).

        On meeting a state again, everything since its first visit is dropped. What is left of a state is its last
        exit, so the path is found by following the last exits from the start.
        """
        self.admit()
        path = np.empty(self.dynamics.n_states, dtype=np.uint32)
        length = self.erase_loops(pointer32(path))
        return path[: length + 1].astype(np.int32)

    # -- learning -----------------------------------------------------------------------------------------------

    cdef void draw_words(self) noexcept nogil:
        cdef int i
        for i in range(WORDS):
            self.words[i] = self.generator.next_uint64(self.generator.state)
        self.next_word = 0

    cdef int admit(self) except -1:
        """Refuse a call from another thread, or from within a call that is still going on."""
        if self.thread != PyThread_get_thread_ident():
            raise RuntimeError("a learner belongs to the thread that made it; make one for each thread")
        if self.busy:
            raise RuntimeError("the learner is in the middle of another call; use it after that has returned")

    cdef int look_at_signals(self) except -1 nogil:
        """Let Python handle signals such as Ctrl-C, whose exception then ends the call."""
        self.until_check = CHECK_EVERY
        with gil:
            self.busy = True
            try:
                PyErr_CheckSignals()
            finally:
                self.busy = False

    cdef uint64_t chance(self, epsilon) except *:
        """The threshold of a given probability of random actions, or of the learner's."""
        return self.epsilon if epsilon is None else threshold(check_probability("epsilon", epsilon))

    cdef void fill_values(self, const double[:, ::1] q) noexcept:
        """Set Q and all tables that follow from it."""
        cdef int state, action
        for state in range(self.dynamics.n_states):
            for action in range(4):
                self.values[4 * state + action] = q[state, action]
            self.refresh(state)

    cdef void enter(self, uint32_t start) noexcept nogil:
        self.start = self.here = start
        self.taken = 0

    cdef void forget(self, uint32_t goal) noexcept nogil:
        """Start a new task from Q = 0; random numbers go on."""
        cdef int i, n = self.dynamics.n_states
        cdef uint32_t state
        for i in range(self.n_informed):
            state = self.informed_states[i]
            memset(&self.values[4 * state], 0, 4 * sizeof(double))
            self.best[state] = self.target[state] = 0.0
            self.greedy[state] = ALL_ACTIONS
            self.informed[state] = 0
            self.fill_moves(state)
        self.n_informed = 0
        if self.notes_pairs:
            memset(self.taken_actions, 0, 4 * n)
            memset(self.taken_pairs, 0, 16 * n)
        memset(self.cold, self.shortcut, n)
        self.target[self.goal] = 0.0
        self.target[goal] = 1.0
        self.goal = goal
        self.warm_up(goal)

    cdef void warm_up(self, uint32_t state) noexcept nogil:
        """No state within two steps before this one is cold any more."""
        cdef uint32_t i, j, one
        cdef uint32_t* first = self.dynamics.first_predecessor
        cdef uint32_t* before = self.dynamics.predecessors
        self.cold[state] = 0
        for i in range(first[state], first[state + 1]):
            one = before[i]
            self.cold[one] = 0
            for j in range(first[one], first[one + 1]):
                self.cold[before[j]] = 0

    cdef void fill_moves(self, uint32_t state) noexcept nogil:
        """Rewrite the greedy slots of a state whose greedy actions have changed; uniform slots never do."""
        cdef uint32_t* row = &self.moves[SLOTS * state]
        cdef int slot
        for slot in range(GREEDY_SLOTS):
            row[slot] = row[GREEDY_SLOTS + greedy_action(self, self.greedy[state], slot)]

    cdef void refresh(self, uint32_t state) noexcept nogil:
        """Find the best value and the greedy actions of a state anew (exact equality makes a tie)."""
        cdef double* q = &self.values[4 * state]
        cdef double first = q[1] if q[1] > q[0] else q[0]
        cdef double second = q[3] if q[3] > q[2] else q[2]
        cdef double best = second if second > first else first
        # none is above the best, and >= needs no check for NaN, which == does
        cdef uint8_t greedy = (q[0] >= best) | (q[1] >= best) << 1 | (q[2] >= best) << 2 | (q[3] >= best) << 3
        cdef uint32_t* row = &self.moves[SLOTS * state]
        cdef uint32_t move
        cdef int slot
        self.best[state] = best
        if state != self.goal:
            self.target[state] = self.gamma * best
        if not greedy & (greedy - 1):
            # One greedy action, by far the most frequent case once Q is informed. Writing its move where it may stand
            # already is faster than a branch that cannot be foreseen.
            self.greedy[state] = greedy
            move = row[GREEDY_SLOTS + (greedy >> 1) - (greedy >> 3)]
            for slot in range(GREEDY_SLOTS):
                row[slot] = move
        elif greedy != self.greedy[state]:
            self.greedy[state] = greedy
            self.fill_moves(state)
        if not self.informed[state]:
            self.inform(state)

    cdef void inform(self, uint32_t state) noexcept nogil:
        """Note that Q is no longer zero in a state, if so."""
        cdef double* q = &self.values[4 * state]
        if q[0] != 0 or q[1] != 0 or q[2] != 0 or q[3] != 0:
            self.informed[state] = 1
            self.informed_states[self.n_informed] = state
            self.n_informed += 1
            self.warm_up(state)

    # -- episodes -----------------------------------------------------------------------------------------------

    cdef int run_greedily(self, int64_t budget, uint64_t epsilon) except -1 nogil:
        if self.record_limit:
            return self.run_greedily_recorded(budget, epsilon)
        cdef int64_t left = max(0, min(budget, self.max_steps - self.taken))
        while True:
            left = self.walk(left, max(0, left - self.until_check), epsilon)
            if self.until_check > 0:
                return 0
            self.look_at_signals()

    cdef int64_t walk(self, int64_t left, int64_t pause, uint64_t epsilon) noexcept nogil:
        """Take steps until the goal or until ``pause`` of the steps left in all, or a few less, are left; return those.

        Pairs of steps may overshoot the pause, because what they draw must not depend on it.
        """
        if self.slip == 0:
            return walk_on(self, left, pause, epsilon, False)
        return walk_on(self, left, pause, epsilon, True)

    cdef int run_greedily_recorded(self, int64_t budget, uint64_t epsilon) except -1 nogil:
        """Act as `run_greedily` does, from the same random numbers, with every step taken by `step`."""
        cdef int64_t left = max(0, min(budget, self.max_steps - self.taken))
        cdef uint64_t word
        cdef int group

        while left > 0 and self.here != self.goal:
            if left >= 2 and self.cold[self.here]:
                if self.next_word == WORDS:
                    self.draw_words()
                word = self.words[self.next_word]
                self.next_word += 1
                for group in range(16):
                    move(self, word & 3)  # the updates leave Q as it is
                    move(self, word >> 2 & 3)
                    word >>= 4
                    left -= 2
                    if left < 2 or not self.cold[self.here]:
                        break
            else:
                step(self, epsilon_greedy(self, epsilon))
                left -= 1
            if self.until_check <= 0:
                self.look_at_signals()
        return 0

    cdef int run_biased(self, int64_t budget, uint64_t epsilon, const double* bonus,
                        const uint8_t* masks) except -1 nogil:
        cdef int64_t end = self.taken + min(budget, self.max_steps - self.taken)
        while self.taken < end and self.here != self.goal:
            step(self, biased_greedy(self, epsilon, &bonus[4 * self.here], masks[self.here]))
            if self.until_check <= 0:
                self.look_at_signals()
        return 0

    cdef int run_policy(self, const signed char* policy, uint32_t subgoal, int64_t budget) except -1 nogil:
        cdef int64_t end = self.taken + min(budget, self.max_steps - self.taken)
        while self.here != subgoal and self.here != self.goal and self.taken < end and policy[self.here] >= 0:
            step(self, policy[self.here])
            if self.until_check <= 0:
                self.look_at_signals()
        return 0

    cdef int run_reuse(self, const signed char* policy, uint32_t subgoal, double psi, double decay) except -1 nogil:
        cdef uint64_t chance = threshold(psi)
        while chance > 0 and self.here != subgoal and self.here != self.goal and self.taken < self.max_steps:
            if draw(self) < chance and policy[self.here] >= 0:
                step(self, policy[self.here])
            else:
                step(self, epsilon_greedy(self, chance))
            psi *= decay
            chance = threshold(psi)
            if self.until_check <= 0:
                self.look_at_signals()
        return self.run_greedily(NO_LIMIT, 0) if subgoal == NO_STATE else 0

    cdef int erase_loops(self, uint32_t* path) noexcept nogil:
        """Write the loop-erased path of this episode; return its length in steps."""
        cdef uint32_t state = self.start
        cdef int length = 0
        path[0] = state
        while state != self.here:
            state = self.dynamics.successors[4 * state + self.last_exit[state]]
            length += 1
            path[length] = state
        return length


def check_probability(name, value):
    """Return a probability, or raise ValueError naming it."""
    if not 0 <= value <= 1:
        raise ValueError(f"{name} must lie in [0, 1], not {value}")
    return value


def check_mixing(psi, decay):
    """Raise ValueError unless pi-reuse with these ends: psi in [0, 1] and decay in [0, 1)."""
    check_probability("psi", psi)
    if not 0 <= decay < 1:
        raise ValueError(f"decay must lie in [0, 1), not {decay}")


cdef int64_t checked_index(name, value, int64_t end) except -1:
    """A whole number from 0 to end - 1, or ValueError naming it."""
    cdef int64_t number
    try:
        number = PyNumber_Index(value)
    except (TypeError, OverflowError):
        number = -1
    if not 0 <= number < end:
        raise ValueError(f"{name} must be a whole number from 0 to {end - 1}, not {value!r}")
    return number


cdef uint32_t checked_subgoal(subgoal, int n_states) except? 0:
    """The state that ends a guidance, `NO_STATE` for None."""
    return NO_STATE if subgoal is None else <uint32_t>checked_index("subgoal", subgoal, n_states)


cdef int64_t checked_budget(budget) except -1:
    """The number of steps in a budget, `NO_LIMIT` for None."""
    return NO_LIMIT if budget is None else checked_index("budget", budget, NO_LIMIT)


cdef double checked_value(value) except *:
    cdef double number = value
    if not fabs(number) <= LARGEST:
        raise ValueError(f"an action value must be finite and at most {LARGEST} in size, not {value!r}")
    return number


def checked_values(name, values, shape):
    """Return a copy of values as a contiguous float64 array of a shape, or raise ValueError."""
    values = np.array(values, order="C")
    if values.dtype.kind not in "biuf":
        raise ValueError(f"{name} must hold numbers, not {values.dtype}")
    values = values.astype(np.float64, copy=False)
    if values.shape != shape:
        raise ValueError(f"{name} must have the shape {shape}, not {values.shape}")
    if not (np.abs(values) <= LARGEST).all():
        raise ValueError(f"{name} must be finite and at most {LARGEST} in size")
    return values


def checked_mask(mask, shape):
    """Return the allowed actions of each state as bits, uint8 array (n_states,), or raise ValueError."""
    mask = np.array(mask)
    if mask.shape != shape or mask.dtype != bool:
        raise ValueError(f"mask must be a bool array of the shape {shape}, not {mask.dtype} {mask.shape}")
    mask = mask.reshape(-1, 4)
    if not mask.any(axis=1).all():
        raise ValueError("mask must allow an action in each state")
    return np.packbits(mask, axis=1, bitorder="little")[:, 0].copy()


def checked_policy(policy, n_states):
    """Return a copy of a policy as an int8 array (n_states,), or raise ValueError."""
    given = np.array(policy, order="C")
    if given.shape == (n_states,) and given.dtype.kind in "iu":
        narrow = given.astype(np.int8, copy=False)
        if (narrow is given or (narrow == given).all()) and are_actions(narrow):
            return narrow
    raise ValueError("a policy needs one action from -1 to 3 for each state")


cdef bint are_actions(const signed char[::1] policy) noexcept:
    """Whether each entry is an action or -1."""
    cdef Py_ssize_t state
    cdef bint fits = True
    for state in range(len(policy)):
        fits &= -1 <= policy[state] <= 3
    return fits
