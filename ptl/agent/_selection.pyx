# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True
# cython: embedsignature=True
"""Draws of skills and arms, compiled because a life has thousands of them and each is a few sums.

What a skill's probability is made of says `ptl.agent.selection`; arms are those of policy reuse.
"""

cimport cython
from cpython.pycapsule cimport PyCapsule_GetPointer
from libc.math cimport exp, log, pow
from libc.stdint cimport int64_t
from numpy.random cimport bitgen_t

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


cdef Py_ssize_t place(const double[::1] weights, double aim) noexcept:
    """The index at which the sum of the weights passes the aim; the last one also if rounding has made them equal."""
    cdef double passed = 0.0
    cdef Py_ssize_t index, last = len(weights) - 1
    for index in range(last):
        passed += weights[index]
        if aim < passed:
            return index
    return last


@cython.final
cdef class Uniform:
    """Uniform numbers from [0, 1): those of ``random.random()``, without the cost of a call if it is numpy's own."""

    cdef object random, capsule
    cdef bitgen_t* generator

    cdef double next(self, random) except? -1:
        if random is not self.random:
            self.random, self.generator = random, NULL
            if type(random) is np.random.Generator:
                # the capsule of the class itself: that of a subclass in Python may belong to an object that is gone
                self.capsule = np.random.BitGenerator.capsule.__get__(random.bit_generator)
                self.generator = <bitgen_t*>PyCapsule_GetPointer(self.capsule, "BitGenerator")
        if self.generator == NULL:
            return random.random()
        return self.generator.next_double(self.generator.state)


cdef class SkillSelection:
    """Draws skills and learns from the episodes how well each one serves the present goal.

    Parameters
    ----------
    prior : float array, shape (k,)
        P(s_i|g).
    exponent : float
        kappa in P(C|s_i, g) proportional to v_i**kappa.
    weight : float
        beta, weight of the newest episode in the moving average v_i of 1 / length.

    Attributes
    ----------
    visits : int
        How often a skill has been looked at by draws so far: what they cost.

    Raises
    ------
    ValueError
        If the prior is no probability distribution.
    """

    cdef double _exponent, _weight
    cdef object _prior
    cdef const double[::1] _log_prior
    cdef double[::1] _measured, _log_measured, _weights
    cdef Uniform _uniform
    cdef readonly int64_t visits

    def __init__(self, prior, double exponent=2.0, double weight=0.5):
        self.prior = prior
        self._exponent, self._weight = exponent, weight
        self._measured, self._weights = np.zeros(len(prior)), np.empty(len(prior))
        self._log_measured = np.zeros(len(prior))
        self._uniform = Uniform()

    @property
    def prior(self):
        """P(s_i|g), float (k,); another one of this length may be set while the task is learned."""
        return self._prior

    @prior.setter
    def prior(self, prior):
        prior = np.array(prior, dtype=np.float64, subok=True)  # an array that counts its use stays one
        if not (prior.ndim == 1 and len(prior) and (prior >= 0).all() and abs(prior.sum() - 1) < 1e-6):  # nor NaN
            raise ValueError(f"the prior must hold probabilities that sum to 1, not {prior}")
        if self._prior is not None and len(prior) != len(self._prior):
            raise ValueError(f"the prior of {len(self._prior)} skills cannot become one of {len(prior)}")
        prior.flags.writeable = False
        self._prior = prior
        with np.errstate(divide="ignore"):
            self._log_prior = np.log(prior)

    @property
    def performance(self):
        """v_i, float (k,): moving average of 1 / length; an unused skill has the best v, 1 before any episode."""
        measured = np.array(self._measured)
        return np.where(measured > 0, measured, measured.max() or 1.0)

    def probabilities(self):
        """Return the probability of drawing each skill, float (k,)."""
        total = self.weigh()
        return np.array(self._weights) / total

    def draw(self, random):
        """Draw a skill; one uniform number and a few loops over the skills."""
        cdef double total = self.weigh()
        cdef Py_ssize_t skill = place(self._weights, self._uniform.next(random) * total)
        self.visits += skill + 1
        return skill

    def record(self, used, length, at_goal=True):
        """Update every skill used in an episode with the episode's length in steps, whether or not it was truncated."""
        cdef double new = 1.0 / length
        cdef Py_ssize_t skill
        for skill in used if len(used) == 1 else set(used):
            if not 0 <= skill < len(self._measured):
                raise IndexError(f"there is no skill {skill} among {len(self._measured)}")
            if self._measured[skill]:
                self._measured[skill] += self._weight * (new - self._measured[skill])
            else:
                self._measured[skill] = new
            self._log_measured[skill] = log(self._measured[skill])

    cdef double weigh(self) except -1:
        """Write a multiple of each skill's probability, the greatest 1, and return their sum."""
        cdef double best = 0.0, greatest = 0.0, total = 0.0, of_unused, performance
        cdef Py_ssize_t skill, number = len(self._weights)
        for skill in range(number):
            self.visits += 1
            best = max(best, self._measured[skill])
        of_unused = log(best) if best > 0 else 0.0
        # in logarithms, because a large exponent takes the product of prior and likelihood out of range
        for skill in range(number):
            self.visits += 1
            performance = self._log_measured[skill] if self._measured[skill] > 0 else of_unused
            self._weights[skill] = self._log_prior[skill] + self._exponent * performance
            if skill == 0 or self._weights[skill] > greatest:
                greatest = self._weights[skill]
        for skill in range(number):
            self.visits += 1
            self._weights[skill] = exp(self._weights[skill] - greatest)
            total += self._weights[skill]
        return total


cdef class ArmSelection:
    """Draws arms by what they have gained (PRQ-learning; source: Fernandez and Veloso, 2006, 2013).

    Arm k is drawn with probability exp(tau W_k) / sum_j exp(tau W_j). W_k is the mean discounted return of the
    episodes of arm k, 0 before the first.

    Parameters
    ----------
    arms : int
    gamma : float
        Discount per step.
    temperature, temperature_step : float
        tau in the first episode, and its growth after every episode.

    Raises
    ------
    ValueError
        If there is no arm.
    """

    cdef double _gamma, _temperature, _step
    cdef double[::1] _gain, _uses, _weights
    cdef Uniform _uniform

    def __cinit__(self, Py_ssize_t arms, double gamma, double temperature, double temperature_step):
        if arms < 1:
            raise ValueError(f"there must be an arm at least, not {arms}")
        self._gamma, self._temperature, self._step = gamma, temperature, temperature_step
        self._gain, self._uses, self._weights = np.zeros(arms), np.zeros(arms), np.empty(arms)
        self._uniform = Uniform()

    @property
    def gain(self):
        """W_k, float (arms,)."""
        return np.array(self._gain)

    @property
    def uses(self):
        """Episodes of each arm so far, float (arms,)."""
        return np.array(self._uses)

    def probabilities(self):
        """Return the probability of drawing each arm, float (arms,)."""
        total = self.weigh()
        return np.array(self._weights) / total

    def draw(self, random):
        """Draw an arm; one uniform number."""
        cdef double total = self.weigh()
        return place(self._weights, self._uniform.next(random) * total)

    def record(self, used, int64_t length, bint at_goal=True):
        """Update the arm used in an episode with its return, and let tau grow."""
        cdef Py_ssize_t arm
        [arm] = used
        if not 0 <= arm < len(self._gain):
            raise IndexError(f"there is no arm {arm} among {len(self._gain)}")
        # the only reward is 1 at the goal, so the return of an episode of m steps is gamma**(m - 1)
        cdef double discounted = pow(self._gamma, length - 1) if at_goal else 0.0
        self._gain[arm] = (self._gain[arm] * self._uses[arm] + discounted) / (self._uses[arm] + 1)
        self._uses[arm] += 1
        self._temperature += self._step

    cdef double weigh(self) noexcept:
        """Write a multiple of each arm's probability, the greatest 1, and return their sum."""
        cdef double greatest = 0.0, total = 0.0
        cdef Py_ssize_t arm
        for arm in range(len(self._gain)):
            greatest = max(greatest, self._gain[arm])
        for arm in range(len(self._gain)):
            self._weights[arm] = exp(self._temperature * (self._gain[arm] - greatest))
            total += self._weights[arm]
        return total
