"""A policy library that grows when it has to: PLPR of Fernandez and Veloso."""

from __future__ import annotations

import numpy as np

from ptl.agent._kernel import Learner
from ptl.methods.policy_reuse import Method as PolicyReuse

DELTA = 0.25
"""delta of their experiments."""


def is_similar(gains: np.ndarray, delta: float = DELTA) -> bool:
    """Return whether a task's policy is delta-similar to one of the library and so is not added.

    Parameters
    ----------
    gains : float array, shape (1 + policies in the library,)
        W of the new policy, then of each policy reused.
    """
    return bool((gains[1:] >= delta * gains[0]).any())


class Method(PolicyReuse):
    """As `policy_reuse`, but a task's policy is kept if no policy of the library would have been nearly as good.

    F. Fernandez, M. Veloso, AAMAS 2006, and Progress in AI 2, 2013: the policy of a task enters the library if
    max_i W_i < delta W, where W is the gain of the new policy and W_i that of reusing policy i, delta = 0.25. The gains
    are those that PRQ-learning has estimated at the end of the task (our choice: the mean return of all episodes of an
    arm). Knows nothing of the goal.
    """

    label = "Policy library (PLPR)"
    colour = "#33a02c"

    def end_task(self, learner: Learner) -> None:
        if not is_similar(self.selection.gain):
            super().end_task(learner)
