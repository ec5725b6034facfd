"""Options to the subgoals of the FD metric, learned about by intra-option Q-learning (Sutton et al., 1999)."""

from __future__ import annotations

from ptl.agent._kernel import Learner
from studies.beyond.methods.options_smdp import N_ACTIONS
from studies.beyond.methods.options_smdp import Method as Options


class Method(Options):
    """As `options_smdp`, but every step teaches about all actions and options that would have taken it.

    Sutton, Precup and Singh, 1999, section 6: for an option o whose policy takes the action of this step from s to s',

        Q(s, o) += alpha (r + gamma U(s', o) - Q(s, o)),

    where U(s', o) = Q(s', o) if o goes on in s', and max Q(s', .) if it ends there; r = 1 and U = 0 at the goal. An
    action ends after its step. Options are still taken to their end. Knows nothing of the goal.
    """

    label = "Options, intra-option learning"
    colour = "#984ea3"

    def take(self, learner: Learner, state: int, choice: int) -> int:
        policy, before = self.policies[choice - N_ACTIONS], -1
        while self.goes_on(policy, before, state) and not learner.truncated:
            before, state = state, self.act(learner, state, policy[state])
        return state

    def act(self, learner: Learner, state: int, action: int) -> int:
        after = learner.act(action, learn=False)
        learning, row, ahead = self.learning, self.values[state], self.values[after]
        at_goal = after == self.goal
        best = 1.0 if at_goal else learning.gamma * max(ahead)
        row[action] += learning.alpha * (best - row[action])
        for number, policy in enumerate(self.policies):
            if policy[state] == action:
                choice = N_ACTIONS + number
                target = learning.gamma * ahead[choice] if self.goes_on(policy, state, after) else best
                row[choice] += learning.alpha * (target - row[choice])
        return after
