# The parts of the episode kernel that other compiled modules of the package use.
cimport cython
from libc.stdint cimport int64_t, uint8_t, uint32_t, uint64_t
from numpy.random cimport bitgen_t

cdef enum:
    SLOTS = 16       # moves of a state in the table: 12 greedy, then 4 uniform
    GREEDY_SLOTS = 12
    ALL_ACTIONS = 15  # the greedy set of a state whose action values are equal

cdef uint32_t NO_STATE  # stands for no subgoal
cdef int64_t NO_LIMIT


@cython.final
cdef class Dynamics:
    cdef readonly int n_states
    cdef readonly double slip
    cdef object _keep, fresh_moves
    cdef uint32_t* successors
    cdef uint32_t* jumps
    cdef uint32_t* predecessors
    cdef uint32_t* first_predecessor


@cython.final
cdef class Learner:
    cdef readonly Dynamics dynamics
    cdef readonly int64_t episodes  # begun so far
    cdef object _keep, _generator
    cdef unsigned long thread
    cdef bint busy
    cdef int64_t until_check  # steps until signals are looked at again
    cdef bitgen_t* generator
    cdef uint64_t[256] words
    cdef int next_word
    cdef uint32_t half
    cdef bint has_half
    cdef bint shortcut
    cdef bint first_of_ties  # False: greedy actions tie at random
    cdef bint notes_pairs  # False: actions taken two at a time are not noted, and `seen` must not be asked for
    cdef double alpha, gamma
    cdef uint64_t epsilon, slip
    cdef int64_t max_steps, taken
    cdef uint32_t start, here, goal
    cdef double* values
    cdef double* best
    cdef double* target
    cdef uint8_t* greedy
    cdef uint32_t* moves
    cdef uint8_t* cold
    cdef uint8_t* informed
    cdef uint8_t* taken_actions
    cdef uint8_t* taken_pairs
    cdef uint8_t* last_exit
    cdef uint32_t* informed_states
    cdef int n_informed
    cdef object _recorded
    cdef uint8_t* directions
    cdef int64_t record_limit

    cdef int admit(self) except -1
    cdef int look_at_signals(self) except -1 nogil
    cdef uint64_t chance(self, epsilon) except *
    cdef void fill_values(self, const double[:, ::1] q) noexcept
    cdef void draw_words(self) noexcept nogil
    cdef void fill_moves(self, uint32_t state) noexcept nogil
    cdef void warm_up(self, uint32_t state) noexcept nogil
    cdef void refresh(self, uint32_t state) noexcept nogil
    cdef void inform(self, uint32_t state) noexcept nogil
    cdef void forget(self, uint32_t goal) noexcept nogil
    cdef void enter(self, uint32_t start) noexcept nogil
    cdef int run_greedily(self, int64_t budget, uint64_t epsilon) except -1 nogil
    cdef int64_t walk(self, int64_t left, int64_t pause, uint64_t epsilon) noexcept nogil
    cdef int run_greedily_recorded(self, int64_t budget, uint64_t epsilon) except -1 nogil
    cdef int run_biased(self, int64_t budget, uint64_t epsilon, const double* bonus,
                        const uint8_t* masks) except -1 nogil
    cdef int run_policy(self, const signed char* policy, uint32_t subgoal, int64_t budget) except -1 nogil
    cdef int run_reuse(self, const signed char* policy, uint32_t subgoal, double psi, double decay) except -1 nogil
    cdef int erase_loops(self, uint32_t* path) noexcept nogil


cdef uint32_t slipped(Learner learner, uint32_t action) noexcept nogil


cdef inline uint32_t direction_of(Learner learner, uint32_t action) noexcept nogil:
    """The direction of a step: that of the action, unless the step slips.

    The action given a direction has the same law if all actions are equally probable.
    """
    return slipped(learner, action) if learner.slip else action


cdef int64_t checked_index(name, value, int64_t end) except -1


cdef inline void update(Learner learner, double* values, const double* target, double alpha,
                        uint32_t state, uint32_t action, uint32_t successor) noexcept nogil:
    """One Q-learning update; the pointers come as arguments because the hot loop keeps them in registers."""
    approach(learner, values, target[successor], alpha, state, action)


cdef inline void approach(Learner learner, double* values, double target, double alpha,
                          uint32_t state, uint32_t action) noexcept nogil:
    """Q(s,a) += alpha (target - Q(s,a)), with all tables that follow from Q."""
    cdef double old = values[4 * state + action]
    cdef double new
    if old == target:
        return
    new = old + alpha * (target - old)
    values[4 * state + action] = new
    if new > learner.best[state]:
        if learner.greedy[state] == 1 << action:
            learner.best[state] = new
            learner.target[state] = learner.gamma * new
            return
    elif new < learner.best[state] and not learner.greedy[state] >> action & 1:
        return
    learner.refresh(state)
