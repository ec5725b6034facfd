"""An agent that knows nothing of this package but Gymnasium environments, and writes its results as a table.

It learns by Sarsa with optimistic initial values, from nothing in every task. `docs/gymnasium.md` shows how its table
enters a run. Usage:

    python examples/gymnasium/agent.py --map env2=config/environments/env2.txt:ABCDEF --output sarsa.csv
"""

import argparse
import csv
from collections.abc import Iterator

import ptl.world.gymnasium_env  # noqa: F401 (registers ptl/GridWorld-v0; without Gymnasium it names the extra)

# isort: split
import gymnasium
import numpy as np

ALPHA, GAMMA, EPSILON = 0.1, 0.95, 0.1


def learn(env: gymnasium.Env, episodes: int, rng: np.random.Generator) -> Iterator[int]:
    """Yield the steps of each episode of one task."""
    q = np.ones((env.observation_space.n, env.action_space.n))

    def choose(state: int) -> int:
        if rng.random() < EPSILON:
            return int(rng.integers(q.shape[1]))
        return int(rng.choice(np.flatnonzero(q[state] == q[state].max())))

    for _ in range(episodes):
        state, _ = env.reset()
        action, steps, over = choose(state), 0, False
        while not over:
            following, reward, over, _, _ = env.step(action)
            steps += 1
            chosen = choose(following)
            target = reward + (0 if over else GAMMA * q[following, chosen])
            q[state, action] += ALPHA * (target - q[state, action])
            state, action = following, chosen
        yield steps


def main() -> None:
    """Learn every task of every map with every seed."""
    parser = argparse.ArgumentParser(description="Sarsa on Gymnasium environments.")
    parser.add_argument("--map", action="append", required=True, help="NAME=FILE:TASKS, may be repeated")
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--episodes", type=int, default=200)
    parser.add_argument("--method", default="gymnasium_sarsa", help="name in the column method")
    parser.add_argument("--output", required=True, help="CSV file to write")
    given = parser.parse_args()
    with open(given.output, "w", newline="") as file:  # noqa: PTH123
        table = csv.writer(file)
        table.writerow(["environment", "method", "task", "seed", "episode", "steps"])
        for text in given.map:
            name, _, rest = text.partition("=")
            path, _, tasks = rest.rpartition(":")
            for seed in range(given.seeds):
                for task in tasks:
                    env = gymnasium.make("ptl/GridWorld-v0", world=path, goal=task)
                    rng = np.random.default_rng([seed, ord(task)])
                    for episode, steps in enumerate(learn(env, given.episodes, rng), start=1):
                        table.writerow([name, given.method, task, seed, episode, steps])


if __name__ == "__main__":
    main()
