"""Q-learning in JAX, compiled for the CPU: a `jax.lax.scan` over the steps of a block in a `jax.lax.while_loop`."""

from __future__ import annotations

from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import lax

from benchmarks.learners import Problem

jax.config.update("jax_enable_x64", True)  # the other learners hold Q in double precision too
jax.config.update("jax_platforms", "cpu")

BLOCK = 4096
"""Steps whose random numbers are drawn at once: drawing them one by one, or one loop over all steps whose number is not
known to the compiler, is ten to sixty times slower."""


class JaxLoop:
    """The whole run of episodes as one compiled loop."""

    def __init__(self, task: Problem, seed: int) -> None:
        self._q = jnp.zeros(task.successors.shape)
        self._key = jax.random.key(seed)
        numbers = (task.start, task.goal, task.alpha, task.gamma, task.epsilon)
        self._learn = partial(_learn, jnp.asarray(task.successors), *numbers)
        self.run(0)  # compiles the loop

    def run(self, episodes: int) -> int:
        """Learn; return the number of steps."""
        self._q, self._key, steps = self._learn(self._q, self._key, episodes)
        return int(steps)

    @property
    def q(self) -> np.ndarray:
        """Action values, float array (n_states, 4)."""
        return np.asarray(self._q)


@partial(jax.jit, donate_argnames="q")
def _learn(
    successors: jax.Array,
    start: int,
    goal: int,
    alpha: float,
    gamma: float,
    epsilon: float,
    q: jax.Array,
    key: jax.Array,
    episodes: int,
) -> tuple[jax.Array, jax.Array, jax.Array]:
    """Learn some episodes; return Q, the next random key and the number of steps."""

    def step(carry: tuple[jax.Array, ...], draw: jax.Array) -> tuple[tuple[jax.Array, ...], None]:
        q, state, steps, done = carry
        values = q[state]
        allowed = (values == values.max()) | (draw[0] < epsilon)
        rank = (draw[1] * allowed.sum()).astype(jnp.int32)  # the action is the allowed one of this rank
        action = jnp.argmax(jnp.cumsum(allowed) > rank)
        after = successors[state, action]
        ended, running = after == goal, done < episodes
        target = jnp.where(ended, 1.0, gamma * q[after].max())
        q = q.at[state, action].add(jnp.where(running, alpha * (target - values[action]), 0.0))
        return (q, jnp.where(ended, start, after), steps + running, done + ended), None

    def block(carry: tuple[Any, ...]) -> tuple[Any, ...]:
        key, fresh = jax.random.split(carry[0])
        learner, _ = lax.scan(step, carry[1:], jax.random.uniform(fresh, (BLOCK, 2), jnp.float32))
        return key, *learner

    zero = jnp.zeros((), jnp.int64)
    begin = (key, q, jnp.asarray(start), zero, zero)
    key, q, _, steps, _ = lax.while_loop(lambda carry: carry[-1] < episodes, block, begin)
    return q, key, steps
