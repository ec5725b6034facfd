"""From learning files to the data set of the page.

The data set is a dictionary that is serializable as JSON::

    actions       names of the actions
    window        episodes of the final mean
    methods       identifier -> {label, colour, guides}; guides: "skills", "policies" (of earlier tasks) or "none"
    environments  list of {name, title, map, parameters, tasks (letters in order), seeds, methods (identifiers), runs}

``runs`` holds for "method/seed" a dictionary {skills, tasks}; a skill is {subgoal, after (index of the task that taught
it), policy} and a task

    name, start, goal, subgoal (-1 if none was added), reason
    steps         steps of each episode
    truncated     episodes (from 0) that ran into the step limit
    log10_value   log10 of max_a Q after the last episode for each state, null where it is 0
    policy        greedy in that Q, first of equal actions
    metric        metric by which the next subgoal was sought, for each state
    drawn         candidates drawn in each episode (0 is no guidance)
    chances       for each candidate its probability in each episode; null if the method has its own selection rule
    first         first episode: {informed, actions, parts}, see `ptl.report.explorer.replay.Notes`

Policies and actions are texts of one letter a state or step, the initial of the action, "." where undefined.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from ptl import methods
from ptl.agent.policies import greedy_policy
from ptl.agent.skills import Skill
from ptl.errors import UserError
from ptl.files.store import Result
from ptl.jobs.learn import TaskView, skills_of, tasks_in
from ptl.methods import BaseMethod
from ptl.methods.policy_reuse import Method as PolicyReuse
from ptl.report.explorer.replay import Notes, replay
from ptl.world.gridworld import ACTIONS

DECIMALS = 4
"""Decimals of shares and of log10 of values; the values are thus accurate to 0.012%."""

LETTERS = np.array([*(name[0].upper() for name in ACTIONS), "."])
"""Letter of each action; the last one is for -1, undefined."""


def collect(results: Iterable[Result], *, window: int, titles: Mapping[str, str] | None = None,
            kinds: Mapping[str, type[BaseMethod]] | None = None) -> dict[str, Any]:  # fmt: skip
    """Return the data set of the page.

    Parameters
    ----------
    results : iterable of Result
        Learning files of one run. Environments and methods keep the order in which they first appear.
    window : int
        Episodes of the final mean.
    titles : mapping, optional
        Title of an environment by name; the name itself when left out.
    kinds : mapping, optional
        Class of a method by identifier; built-in ones can be left out.

    Raises
    ------
    UserError
        If a file cannot be used, or cannot be learned again.
    """
    environments: dict[str, dict[str, Any]] = {}
    shown: dict[str, dict[str, str]] = {}
    for result in results:
        method = result.job.method
        kind = (kinds or {}).get(method) or methods.load(method)
        _add(result, environments, titles or {}, kind)
        shown[method] = _look(result, kind)
    if not environments:
        raise UserError("no learning file to show; name the files of a run")
    return {
        "actions": list(ACTIONS),
        "window": window,
        "methods": shown,
        "environments": list(environments.values()),
    }


def _add(
    result: Result, environments: dict[str, dict[str, Any]], titles: Mapping[str, str], kind: type[BaseMethod]
) -> None:
    job = result.job
    fresh = {
        "name": job.environment,
        "title": titles.get(job.environment, job.environment),
        "map": result.world.text,
        "parameters": job.parameters,
        "tasks": list(job.tasks),
        "seeds": [],
        "methods": [],
        "runs": {},
    }
    entry = environments.setdefault(job.environment, fresh)
    if job.method not in entry["methods"]:
        entry["methods"].append(job.method)
    entry["seeds"] = sorted({*entry["seeds"], job.seed})
    tasks = zip(tasks_in(result).values(), replay(result, kind), strict=True)
    entry["runs"][f"{job.method}/{job.seed}"] = {
        "skills": [_skill(skill) for skill in skills_of(result.arrays) or []],
        "tasks": [_task(task, notes) for task, notes in tasks],
    }


def _look(result: Result, kind: type[BaseMethod]) -> dict[str, str]:
    guides = (
        "policies" if issubclass(kind, PolicyReuse) else "skills" if "library/subgoals" in result.arrays else "none"
    )
    return {"label": kind.label, "colour": kind.colour, "guides": guides}


def _skill(skill: Skill) -> dict[str, Any]:
    return {"subgoal": skill.subgoal, "after": skill.learned_after, "policy": _letters(skill.policy)}


def _task(task: TaskView, notes: Notes) -> dict[str, Any]:
    values = task.q.max(axis=1)
    return {
        "name": task.name,
        "start": task.start,
        "goal": task.goal,
        "subgoal": task.subgoal,
        "reason": task.reason,
        "steps": task.steps.tolist(),
        "truncated": np.flatnonzero(task.truncated).tolist(),
        "log10_value": [round(float(np.log10(value)), DECIMALS) if value else None for value in values],
        "policy": _letters(greedy_policy(task.q)),
        "metric": _rounded(task.incremental),
        "drawn": [part.tolist() for part in np.split(task.selected, task.selected_offsets[1:-1])],
        "chances": _rounded(np.transpose(notes.chances)) if notes.chances else None,
        "first": {"informed": notes.informed, "actions": _letters(notes.actions), "parts": notes.parts},
    }


def _letters(actions: np.ndarray) -> str:
    return "".join(LETTERS[actions])


def _rounded(shares: np.ndarray) -> list[Any]:
    return np.round(shares, DECIMALS).tolist()
