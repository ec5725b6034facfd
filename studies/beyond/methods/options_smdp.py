"""Options to the subgoals of the FD metric, learned about by SMDP Q-learning (Sutton, Precup and Singh, 1999)."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ptl.agent._kernel import Learner
from ptl.agent.skills import Skill, SkillLibrary
from ptl.config import Parameters
from ptl.methods._base import BaseMethod
from ptl.world.gridworld import GridWorld

N_ACTIONS = 4
BLOCK = 1024
"""Random numbers drawn at a time."""


def uniform_numbers(random: np.random.Generator) -> Iterator[float]:
    """Yield random numbers in [0, 1), the last of each block first."""
    while True:
        yield from reversed(random.random(BLOCK).tolist())


def initiation_set(option: Skill) -> np.ndarray:
    """Return the states in which an option can be chosen, bool (n_states,)."""
    assert option.initiation is not None  # the library keeps these sets
    return option.initiation & (option.policy >= 0)


class Method(BaseMethod):
    """Q-learning over the four actions and the skills of `ptl`, which are options here; Q = 0 in each task.

    R. Sutton, D. Precup, S. Singh, Artificial Intelligence 112, 1999; over the subgoals of the FD metric: R. Kretchmar,
    T. Feil, R. Bansal, 2003. An option is a skill: it can be chosen in the states before its subgoal on the paths that
    taught it (A. McGovern, A. Barto, ICML 2001), and lasts until its subgoal, to the goal, or until a step leaves the
    agent where it was (our choice: a door may have closed). After k steps of an option from s to s',

        Q(s, o) += alpha (r + gamma^k max Q(s', .) - Q(s, o)),

    with r = gamma^(k - 1) and no bootstrap at the goal; steps inside of an option teach nothing else. Actions and
    options are chosen epsilon-greedily among all that the state has, with random ties. When skills are added, and
    where, is as in `ptl`.

    Two rules are ours and favour the options. A state on no path before the subgoal does not offer the option, and once
    an episode has had as many steps as there are states, options are no longer drawn at random. Where nothing is known,
    they are drawn as often as actions, lead a random walk back to their subgoals again and again, and a goal aside of
    them is hardly ever found.

    Knows nothing of the goal.

    Attributes
    ----------
    values : list of lists of float
        Q of the actions and then of the options of each state, -inf where an option cannot be chosen.
    """

    label = "Options, SMDP Q-learning"
    colour = "#f781bf"

    def __init__(self, world: GridWorld, parameters: Parameters, random: np.random.Generator) -> None:
        super().__init__(world, parameters, random)
        self.learning, subgoals = parameters.learning, parameters.subgoals
        self.library: SkillLibrary = SkillLibrary(subgoals.novelty, subgoals.threshold, initiation_sets=True)
        self.uniform = uniform_numbers(random)

    def begin_task(self, start: int, goal: int) -> np.ndarray | None:
        self.goal = goal
        self.options: list[Skill] = list(self.library)
        values = np.zeros((self.world.n_states, N_ACTIONS + len(self.options)))
        for number, option in enumerate(self.options, N_ACTIONS):
            values[~initiation_set(option), number] = -np.inf
        self.values: list[list[float]] = values.tolist()
        self.policies: list[list[int]] = [option.policy.tolist() for option in self.options]
        return None

    def run_episode(self, learner: Learner) -> list[int]:
        taken = []
        state, goal, n_states = learner.state, self.goal, self.world.n_states
        while not (state == goal or learner.truncated):
            choice = self.choose(state, N_ACTIONS if learner.steps >= n_states else None)
            if choice < N_ACTIONS:
                state = self.act(learner, state, choice)
            else:
                taken.append(choice - N_ACTIONS + 1)
                state = self.take(learner, state, choice)
        return taken

    def choose(self, state: int, random_end: int | None = None) -> int:
        """Return the number of an action, or 4 + i for option i, epsilon-greedily among those that the state has.

        Parameters
        ----------
        random_end : int, optional
            Only numbers below it are drawn at random: by epsilon, and where all values are 0.
        """
        row = self.values[state]
        best = max(row)
        if next(self.uniform) < self.learning.epsilon:
            among = [choice for choice, value in enumerate(row[:random_end]) if value > -np.inf]
            return among[int(next(self.uniform) * len(among))]
        if best == 0:
            row = row[:random_end]
        ties, choice = row.count(best), row.index(best)
        for _ in range(int(next(self.uniform) * ties) if ties > 1 else 0):
            choice = row.index(best, choice + 1)
        return choice

    def act(self, learner: Learner, state: int, action: int) -> int:
        """Take an action and learn about it; return the state after it."""
        after = learner.act(action, learn=False)
        self.learn(state, action, after, 1)
        return after

    def take(self, learner: Learner, state: int, choice: int) -> int:
        """Take an option to its end and learn about it; return the state after it."""
        policy, before, after, steps = self.policies[choice - N_ACTIONS], -1, state, 0
        while self.goes_on(policy, before, after) and not learner.truncated:
            before, after, steps = after, learner.act(policy[after], learn=False), steps + 1
        self.learn(state, choice, after, steps)
        return after

    def goes_on(self, policy: list[int], before: int, state: int) -> bool:
        """Return whether an option goes on after a step; ``before`` is -1 where it begins."""
        return state not in (before, self.goal) and policy[state] >= 0

    def learn(self, state: int, choice: int, after: int, steps: int) -> None:
        """Update Q of an action or option that led from a state to another in some steps."""
        gamma, row = self.learning.gamma, self.values[state]
        target = gamma ** (steps - 1) if after == self.goal else gamma**steps * max(self.values[after])
        row[choice] += self.learning.alpha * (target - row[choice])

    def end_task(self, learner: Learner) -> None:
        learner.set_q(np.array(self.values)[:, :N_ACTIONS])
