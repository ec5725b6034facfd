"""A learning job: one life, all tasks of an environment under one method with one seed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Annotated, Any, NamedTuple

import numpy as np
from msgspec import Meta

from ptl import methods
from ptl.agent.skills import Skill, SkillLibrary
from ptl.files.formats import Array
from ptl.files.job import Job, Number, Watch, Word, Worlds, register
from ptl.files.outside import configured, learning_code
from ptl.files.provenance import LEARNING
from ptl.files.store import Result
from ptl.learning.life import TaskRecord, learn_life, tasks_of
from ptl.world.gridworld import GridWorld

INITIATION = "initiation/sets"  # in a group of its own, because the arrays of a group are all present or all absent
LIBRARY = {
    "library/subgoals": Array("int32", ("k",), "state that each skill leads to", 0, "n-1", True),
    "library/policies": Array(
        "int8", ("k", "n"), "action of each skill in each state, −1 where undefined", -1, 3, True
    ),
    "library/learned_after": Array("int32", ("k",), "index of the task after which it was added", 0, None, True),
    INITIATION: Array("bool", ("k", "n"), "initiation set of each skill, only if skills have such sets", optional=True),
}
"""The library after the last task, k skills; only of methods that keep one."""


@register
class Learn(Job, frozen=True, kw_only=True, tag="learning/2"):
    """One learner's life: all tasks in order."""

    environment: Annotated[Word, Meta(description="name of the environment")]
    tasks: Annotated[
        str, Meta(description="goal letters in the order in which they are learned", pattern="^[A-HJ-Z]+$")
    ]
    method: Annotated[Word, Meta(description="identifier of the method")]
    reference: Annotated[str, Meta(description="the method as the configuration names it")]
    own: Annotated[dict[str, Any], Meta(description="parameters of the method's own")] = {}  # noqa: RUF012 (msgspec copies it)
    seed: Annotated[Number, Meta(description="number of the seed")]

    TITLE = "Learning files"
    READS = ("learning", "skills", "subgoals", "policy_reuse", "full_transfer")
    ARRAYS = {  # noqa: RUF012
        "tasks/<task>/start": Array("int64", (), "state where episodes begin", 0, "n-1"),
        "tasks/<task>/goal": Array("int64", (), "state where they end", 0, "n-1"),
        "tasks/<task>/q": Array("float64", ("n", 4), "action values after the last episode"),
        "tasks/<task>/seen": Array("uint8", ("n",), "bit a is set if action a was taken in the state", 0, 15),
        "tasks/<task>/steps": Array("int64", ("e",), "steps of each episode, guided ones included", 0),
        "tasks/<task>/truncated": Array("bool", ("e",), "whether the episode ran into the step limit"),
        "tasks/<task>/selected": Array("int32", ("m",), "skills or arms drawn, episode after episode", 0),
        "tasks/<task>/selected_offsets": Array(
            "int64", ("e+1",), "limits of each episode's draws in `selected`", 0, "m"
        ),
        "tasks/<task>/original": Array("float64", ("n",), "original metric, frequency times distance", 0, 1),
        "tasks/<task>/incremental": Array("float64", ("n",), "the same on the unknown rests of the paths", 0, 1),
        "tasks/<task>/subgoal": Array("int64", (), "state of the skill added after the task, −1 if none", -1, "n-1"),
        "tasks/<task>/reason": Array("bytes", (), "why it was added, or why not"),
        "tasks/<task>/novelty": Array("float64", (), "mean length of the unknown rests of the paths", 0, "n-1"),
        "tasks/<task>/diameter": Array("int64", (), "$D$, longest shortest path between visited states", 0, "n-1"),
        **LIBRARY,
    }

    @property
    def place(self) -> str:
        """Path of the file below results/<run>/."""
        return f"learning/{self.environment}/{self.method}/seed_{self.seed:03d}.h5"

    def sources(self) -> str | None:
        """Return the digest of the present sources; None for a method that only an import would find."""
        known = ":" not in self.reference or self.reference.startswith(LEARNING)
        return learning_code(self.reference) if known else None

    def run(self, worlds: Worlds, watch: Watch = iter) -> dict[str, np.ndarray]:
        """Learn the tasks."""
        world, kind = worlds[self.environment], configured(self.reference, self.own)
        tasks = watch(tasks_of(world, self.tasks))
        with methods.reporting_errors_of(self.reference):
            life = learn_life(world, tasks, kind, self.settings, self.root_seed, self.environment, self.seed)
        arrays: dict[str, np.ndarray] = {}
        for record in life.records:
            arrays |= {f"tasks/{record.task.name}/{name}": values for name, values in _task_arrays(record).items()}
        return arrays | library_arrays(life.library, world.n_states)

    def sizes(self, worlds: Worlds) -> dict[str, int]:
        """Return the numbers of states and of episodes."""
        return {"n": worlds[self.environment].n_states, "e": self.settings.learning.episodes}

    def faults(self, arrays: Mapping[str, np.ndarray], worlds: Worlds) -> Iterator[str]:
        """Yield the impossible values."""
        world, limit = worlds[self.environment], self.settings.learning.max_steps
        if {name.split("/")[1] for name in arrays if name.startswith("tasks/")} != {*self.tasks}:
            yield f"its tasks are not {self.tasks}"
            return
        for letter in self.tasks:
            task = {name: arrays[f"tasks/{letter}/{name}"] for name in TaskView._fields[1:]}
            if (task["start"], task["goal"]) != (world.start, world.goals.get(letter)):
                yield f"task {letter}: does not lead from the start of the map to its goal"
            shortest = world.shortest_path_length(world.start, world.goal(letter))
            yield from (f"task {letter}: {fault}" for fault in episode_faults(task["steps"], shortest, limit))
            if (task["steps"][task["truncated"]] != limit).any():
                yield f"task {letter}: a truncated episode does not have learning.max_steps ({limit}) steps"
            offsets = task["selected_offsets"]
            if offsets[0] or (np.diff(offsets) < 0).any() or offsets[-1] != len(task["selected"]):
                yield f"task {letter}: the skills drawn do not fit the episodes"
            if self.method in methods.names() and not ((task["q"] >= 0) & (task["q"] <= 1)).all():
                yield f"task {letter}: a value of Q is outside [0, 1]"
        yield from library_faults(arrays, world, len(self.tasks))
        if "library/subgoals" in arrays:
            added = [int(arrays[f"tasks/{letter}/subgoal"]) for letter in self.tasks]
            if [state for state in added if state >= 0] != arrays["library/subgoals"].tolist():
                yield "its library is not made of the subgoals found"


def episode_faults(steps: np.ndarray, shortest: int, limit: int) -> Iterator[str]:
    """Yield the impossible values in steps per episode."""
    if ((steps < shortest) & (steps != limit)).any():
        yield f"an episode is shorter than the shortest path of {shortest} steps"
    if (steps > limit).any():
        yield f"an episode is longer than learning.max_steps ({limit})"


# -- the library --------------------------------------------------------------------------------------------------


def library_arrays(library: SkillLibrary | None, n_states: int) -> dict[str, np.ndarray]:
    """Return the arrays `LIBRARY` of a library, none without one."""
    if library is None:
        return {}
    # The skills and not `library.subgoals`: a library that makes its policies when they are drawn has none to store.
    skills = library.skills
    sets = [np.zeros(n_states) if skill.initiation is None else skill.initiation for skill in skills]
    some = any(skill.initiation is not None for skill in skills)
    return ({INITIATION: np.array(sets, dtype=bool)} if some else {}) | {
        "library/subgoals": np.array([skill.subgoal for skill in skills], dtype=np.int32),
        "library/policies": np.array([skill.policy for skill in skills], dtype=np.int8).reshape(-1, n_states),
        "library/learned_after": np.array([skill.learned_after for skill in skills], dtype=np.int32),
    }


def library_faults(arrays: Mapping[str, np.ndarray], world: GridWorld, tasks: int) -> Iterator[str]:
    """Yield the impossible values in the arrays `LIBRARY`, if these exist."""
    if (arrays.get("library/learned_after", np.zeros(1)) >= tasks).any():
        yield "its library has a skill of a task that is not there"
    if INITIATION in arrays and len(arrays[INITIATION]) != len(arrays.get("library/subgoals", ())):
        yield "its library has not one initiation set for each skill"
        return
    for skill in skills_of(arrays) or []:
        if not leads_to_subgoal(skill, world.successors):
            yield f"skill of state {skill.subgoal}: its policy does not lead to the subgoal"


def leads_to_subgoal(skill: Skill, successors: np.ndarray) -> bool:
    """Return whether a policy reaches its subgoal from every state where it is defined."""
    states = np.arange(len(successors))
    defined = skill.policy >= 0
    after = np.where(defined, successors[states, np.maximum(skill.policy, 0)], states)
    after[skill.subgoal] = skill.subgoal
    for _ in range(len(successors).bit_length()):  # 1, 2, 4, ... steps
        after = after[after]
    return bool((after[defined] == skill.subgoal).all())


def skills_of(arrays: Mapping[str, np.ndarray]) -> list[Skill] | None:
    """Return the skills of the arrays `LIBRARY`, None if the method keeps no library."""
    if "library/subgoals" not in arrays:
        return None
    subgoals = arrays["library/subgoals"]
    sets = arrays.get(INITIATION, [None] * len(subgoals))
    rows = zip(subgoals, arrays["library/policies"], arrays["library/learned_after"], sets, strict=True)
    return [Skill(int(subgoal), policy, int(after), states) for subgoal, policy, after, states in rows]


# -- reading ------------------------------------------------------------------------------------------------------


class TaskView(NamedTuple):
    """One task of a learning file; the arrays of `Learn.ARRAYS`, scalars as Python's numbers and text."""

    name: str
    start: int
    goal: int
    q: np.ndarray
    seen: np.ndarray
    steps: np.ndarray
    truncated: np.ndarray
    selected: np.ndarray
    selected_offsets: np.ndarray
    original: np.ndarray
    incremental: np.ndarray
    subgoal: int
    reason: str
    novelty: float
    diameter: int

    def selected_in(self, episode: int) -> list[int]:
        """Return the skills or arms drawn in an episode (counted from 0), in order."""
        first, last = self.selected_offsets[episode : episode + 2]
        return self.selected[first:last].tolist()


def tasks_in(result: Result) -> dict[str, TaskView]:
    """Return the tasks of a learning file by letter, in the order in which they were learned."""
    views = {}
    for letter in result.job.tasks:
        values: list[Any] = [result.arrays[f"tasks/{letter}/{name}"] for name in TaskView._fields[1:]]
        plain: list[Any] = [value.item() if value.ndim == 0 else value for value in values]
        views[letter] = TaskView._make(
            [letter, *(part.decode() if isinstance(part, bytes) else part for part in plain)]
        )
    return views


def _task_arrays(record: TaskRecord) -> dict[str, np.ndarray]:
    discovery, update = record.discovery, record.update
    return {
        "start": np.array(record.task.start),
        "goal": np.array(record.task.goal),
        "q": record.q,
        "seen": record.seen,
        "steps": record.steps,
        "truncated": record.truncated,
        "selected": np.array([skill for used in record.selected for skill in used], dtype=np.int32),
        "selected_offsets": np.cumsum([0] + [len(used) for used in record.selected], dtype=np.int64),
        "original": discovery.original.product,
        "incremental": discovery.incremental.product,
        "subgoal": np.array(update.subgoal),
        "reason": np.array(update.reason.encode()),
        "novelty": np.array(discovery.novelty, dtype=np.float64),
        "diameter": np.array(discovery.diameter),
    }
