"""From learning files to the compact data set of the page.

The data set is a dictionary that JSON can hold; arrays are packed as `ptl.explorer.encoding` says::

    format        "ptl-explorer/1"
    actions       names of the actions
    environments  list of {name, title, map, parameters, tasks (letters), seeds, methods (identifiers), runs}
    methods       identifier -> {label, colour, guides, episode}
                  guides: "skills", "policies" (of earlier tasks) or "none"
                  episode: how its first episode goes: "explore", "skills", "reuse" or "unknown"

``runs`` holds for "method/seed" a dictionary {skills, tasks}; a skill is {subgoal, after (index of the task
that taught it), policy (actions)} and a task

    name, start, goal, subgoal (-1 if none was added), reason
    steps         varints, one an episode
    truncated     episodes (from 0) that ran into the step limit
    value         logarithms of max_a Q after the last episode, one a state
    policy        actions, greedy in that Q, first of equal ones
    metric        shares: the metric by which the next subgoal was sought, one a state
    drawn         varints: for each episode the number of draws and then the draws (0 is no guidance)
    chances       share rows (episodes, candidates); null if the method draws by a rule of its own
    initial       logarithms of the Q that the task started from (states, 4), null for zero
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from ptl import methods
from ptl.errors import UserError
from ptl.explorer import encoding
from ptl.explorer.replay import Choices, replay
from ptl.gridworld import ACTIONS
from ptl.methods.policy_reuse import Method as PolicyReuse
from ptl.methods.ptl import Method as PartialTransfer
from ptl.policies import greedy_policy
from ptl.skills import Skill
from ptl.store import LearningFile, TaskView, open_learning

FORMAT = "ptl-explorer/1"


def collect(
    paths: Iterable[str | Path], seeds: Iterable[int] | None = None, titles: Mapping[str, str] | None = None
) -> dict[str, Any]:
    """Build the data set of the page.

    Parameters
    ----------
    paths : paths of learning files
        Environments and methods keep the order in which they first appear.
    seeds : iterable of int, optional
        Seeds to keep; all that are found when left out.
    titles : mapping, optional
        Title of an environment by name; the name itself when left out.

    Raises
    ------
    UserError
        If a file is damaged, two files disagree on map or parameters, or a method lacks a seed that another
        one has.
    """
    wanted = None if seeds is None else set(seeds)
    environments: dict[str, dict[str, Any]] = {}
    kinds: dict[str, dict[str, str]] = {}
    for path in paths:
        with open_learning(path) as file:
            if wanted is None or file.seed in wanted:
                _add(file, environments, kinds, titles or {})
    if not environments:
        raise UserError("no learning file to show; name the files of a run, with the seeds that --seed asks for")
    _check_complete(environments.values(), wanted)
    return {
        "format": FORMAT,
        "actions": list(ACTIONS),
        "methods": kinds,
        "environments": list(environments.values()),
    }


def _add(
    file: LearningFile,
    environments: dict[str, dict[str, Any]],
    kinds: dict[str, dict[str, str]],
    titles: Mapping[str, str],
) -> None:
    fresh = {
        "name": file.environment,
        "title": titles.get(file.environment, file.environment),
        "map": file.world.text,
        "parameters": file.parameters,
        "tasks": list(file.tasks),
        "seeds": [],
        "methods": [],
        "runs": {},
    }
    entry = environments.setdefault(file.environment, fresh)
    for key in ("map", "parameters", "tasks"):
        if entry[key] != fresh[key]:
            raise UserError(
                f"{file.file.filename}: its {key} differ from those of earlier files of {file.environment};"
                " give the files of one run"
            )
    name = f"{file.method}/{file.seed}"
    if name in entry["runs"]:
        raise UserError(f"{file.file.filename}: {file.environment}/{name} is given twice; name each run once")
    if file.method not in entry["methods"]:
        entry["methods"].append(file.method)
    entry["seeds"] = sorted({*entry["seeds"], file.seed})
    choices = list(replay(file))
    entry["runs"][name] = {
        "skills": [_skill(skill) for skill in file.library or []],
        "tasks": [_task(task, choice) for task, choice in zip(file.tasks.values(), choices, strict=True)],
    }
    kinds[file.method] = _kind(file, choices)


def _kind(file: LearningFile, choices: list[Choices]) -> dict[str, str]:
    kind = methods.load(file.method)
    guides, episode = "none", "unknown"
    if issubclass(kind, PolicyReuse):
        guides, episode = "policies", "reuse"
    elif file.library is not None:
        guides = "skills"
        if issubclass(kind, PartialTransfer) and choices[0].probabilities is not None:
            episode = "skills"
    elif not any(len(task.selected) for task in file.tasks.values()):
        episode = "explore"
    return {"label": kind.label, "colour": kind.colour, "guides": guides, "episode": episode}


def _skill(skill: Skill) -> dict[str, Any]:
    return {"subgoal": skill.subgoal, "after": skill.learned_after, "policy": encoding.actions(skill.policy)}


def _task(task: TaskView, choice: Choices) -> dict[str, Any]:
    q = task.q
    return {
        "name": task.name,
        "start": task.start,
        "goal": task.goal,
        "subgoal": task.subgoal,
        "reason": task.reason,
        "steps": encoding.varints(task.steps),
        "truncated": np.flatnonzero(task.truncated).tolist(),
        "value": encoding.logarithms(q.max(axis=1)),
        "policy": encoding.actions(greedy_policy(q)),
        "metric": encoding.shares(task.incremental),
        "drawn": encoding.varints(_counted(task)),
        "chances": None if choice.probabilities is None else encoding.share_rows(choice.probabilities),
        "initial": None if choice.initial_q is None else encoding.logarithms(choice.initial_q),
    }


def _counted(task: TaskView) -> Iterator[int]:
    selected, offsets = task.selected, task.selected_offsets
    for first, last in pairwise(offsets):
        yield int(last - first)
        yield from selected[first:last].tolist()


def _check_complete(environments: Iterable[dict[str, Any]], wanted: set[int] | None) -> None:
    for entry in environments:
        for seed in sorted(wanted or entry["seeds"]):
            for method in entry["methods"]:
                if f"{method}/{seed}" not in entry["runs"]:
                    raise UserError(
                        f"{entry['name']}/{method}: no file of seed {seed} among those given; name it too,"
                        " or leave the seed out (--seed)"
                    )
