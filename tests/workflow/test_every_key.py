"""Every key of the configuration changes some job of the workflow: none is ignored."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Callable, Iterator
from functools import cache
from itertools import product
from pathlib import Path
from typing import Any, Literal, get_args, get_origin

import pytest
from projects import ROOT
from snakemake.api import SnakemakeApi
from snakemake.settings.types import (
    ConfigSettings,
    DAGSettings,
    OutputSettings,
    Quietness,
    ResourceSettings,
)

from ptl.config import Configuration
from ptl.keys import Key, keys_of

TARGETS = {"all"}

TINY = """
run: tiny
seeds: 2
environments:
  rooms: {map: rooms.txt, tasks: AB}
  again: {map: rooms.txt, tasks: BA}
  env1: {map: rooms.txt, tasks: AB, article_items: {discovery: figure11}}
methods: [no_transfer, full_transfer, policy_reuse, ptl, mine.py]
growth: {tasks: 9, runs: 2}
subgoal_frequencies: {batches: 1}
"""

ROOMS = "#########\n#I..#..A#\n#.......#\n#...#..B#\n#########\n"

ROS = {
    "ros.pgm": "P2\n9 5\n255\n" + "254 " * 45 + "\n",
    "ros.yaml": "image: ros.pgm\nresolution: 0.5\norigin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.65\n"
    "free_thresh: 0.2\n",
}

MINE = """
from typing import Annotated

from ptl.keys import Group, key
from ptl.methods.no_transfer import Method as NoTransfer


class Own(Group, frozen=True, kw_only=True):
    weight: Annotated[float, key("Weight.", ge=0, le=10)] = 1.0


class Method(NoTransfer):
    label = "Mine"
    colour = "#123456"
    own = Own()
"""

Jobs = dict[str, tuple[Any, ...]]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a tiny run."""
    folder = tmp_path_factory.mktemp("tiny")
    shutil.copytree(ROOT / "config", folder / "config")
    texts = {"config/config.yaml": TINY, "rooms.txt": ROOMS, "mine.py": MINE, **ROS}
    for name, text in texts.items():
        (folder / name).write_text(text)
    places = product("AB", range(2), range(1, 201))
    rows = [f"rooms,rooms,{task},{seed},{episode},999\n" for task, seed, episode in places]
    for name in ("walker.csv", "same.csv"):
        (folder / name).write_text("environment,method,task,seed,episode,steps\n" + "".join(rows))
    shutil.copy(folder / "rooms.txt", folder / "same.txt")
    return folder


def work_of(job: Any) -> tuple[Any, ...]:
    """Return the rule of a job and what decides on its result: files, and the command or the parameters of a script.

    Captions and the manifest quote the configuration and do nothing with it. So does a parameter that a command
    leaves out.
    """
    quoted = {"caption", "config"}
    given = {name: value for name, value in job.params.items() if name not in quoted}
    return job.rule.name, list(map(str, job.input)), job.shellcmd or given


@pytest.fixture(scope="module")
def jobs_of(folder: Path) -> Iterator[Callable[[dict[str, Any]], Jobs]]:
    """A function from changes of the configuration to the jobs of the workflow, by their first outputs."""

    def refused(status: int) -> None:
        raise AssertionError(f"the workflow ended with status {status}; see stderr")

    @cache
    def jobs(changes: str) -> Jobs:
        with SnakemakeApi(OutputSettings(quiet={Quietness.ALL})) as api:
            loaded = api.workflow(
                resource_settings=ResourceSettings(cores=1),
                config_settings=ConfigSettings(config=json.loads(changes)),
                snakefile=ROOT / "Snakefile",
                workdir=folder,
            )
            loaded.dag(DAGSettings(targets=TARGETS))
            workflow = loaded._workflow
            workflow._prepare_dag(forceall=True, ignore_incomplete=True, lock_warn_only=True)
            workflow._build_dag()
            return {str(job.output[0]): work_of(job) for job in workflow.dag.jobs if job.output}

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(os, "_exit", refused)
        patch.chdir(folder)
        yield lambda changes: jobs(json.dumps(changes))


def changed_jobs(before: Jobs, after: Jobs) -> set[str]:
    """Return the outputs of jobs that are new, gone or different."""
    return {name for name in {*before, *after} if before.get(name) != after.get(name)}


TEXTS = {
    "run": "other",
    "environments.rooms.map": "same.txt",
    "environments.rooms.title": "Another title",
    "environments.rooms.tasks": "BA",
    "environments.rooms.discovery_tasks": "B",
    "foreign_results.rooms.file": "same.csv",
    "foreign_results.rooms.label": "Another label",
    "foreign_results.rooms.colour": "#ffffff",
    "growth.environment": "rooms",
}
"""Another value for each key that is a free text."""

FOREIGN = {"foreign_results": {"rooms": {"file": "walker.csv"}}}
"""Results of another program, which fit one number of seeds and episodes only."""

OPTIONS = "environments.rooms.map_options."
LISTS = {
    "methods": ["ptl", "no_transfer", "policy_reuse"],
    "method_parameters": {"mine": {"weight": 2}},
    "decision.looks": [50, 100],
    f"{OPTIONS}start": [2, 2],
    f"{OPTIONS}goals": [[2, 4], [4, 6]],
    f"{OPTIONS}seed": 5,
    f"{OPTIONS}cell": 1.0,
}
"""Another value for each key that is a list, and for options of maps."""


def base_of(name: str) -> dict[str, Any]:
    """Return what must be given before a key can be: results of another program, or a map that leaves things open."""
    if name.startswith("foreign_results"):
        return FOREIGN
    if name.startswith(OPTIONS) and not name.endswith("format"):
        return {"environments": {"rooms": {"map": "ros.yaml"}}}
    return {}


LEARNING = {"learn", "grow", "decide"}
RULES = {
    "run": {"learn", "grow", "survey_batch", "measure", "tabulate", "judge_claims", "draw_figure"},
    "root_seed": {*LEARNING, "survey_batch"},
    "seeds": {"learn", "measure"},
    "methods": {"measure", "tabulate", "front_page", "build_explorer"},
    "method_parameters": {"learn", "build_explorer"},
    "environments.rooms.map": {"learn", "survey_batch", "judge_claims", "draw_figure"},
    "environments.rooms.title": {"tabulate", "draw_figure", "build_explorer", "front_page"},
    "environments.rooms.tasks": {"learn", "judge_claims", "tabulate", "draw_figure"},
    "environments.rooms": {"draw_figure"},
    f"{OPTIONS}slip": {"learn", "survey_batch"},
    "foreign_results": {"measure", "tabulate", "draw_figure", "front_page"},
    "learning": {*LEARNING, "survey_batch"},
    "learning.max_steps": {"learn", "grow", "survey_batch", "decide"},
    "skills": LEARNING,
    "subgoals": LEARNING,
    "policy_reuse": LEARNING,
    "full_transfer": {"learn", "decide"},
    "measures": {"measure", "judge_claims", "draw_figure"},
    "statistics": {"tabulate", "judge_claims", "draw_figure"},
    "decision": {"decide"},
    "growth.environment": {"grow"},
    "growth.tasks": {"grow", "decide"},
    "growth.runs": {"grow", "collect_growth"},
    "growth.breakpoint": {"draw_figure", "judge_claims"},
    "subgoal_frequencies.batches": {"survey_batch", "merge_survey"},
    "subgoal_frequencies": {"survey_batch"},
}
"""Rules that act on a key or on all keys of a group."""


def other_value(key: Key, name: str) -> Any:
    """Return an allowed value that differs from the one in the tiny run."""
    if name in LISTS:
        return LISTS[name]
    kind = get_args(key.type)[0]
    options = [kind, *get_args(kind)]
    for option in options:
        if get_origin(option) is Literal:
            return next((value for value in get_args(option) if value != key.default), 2)
    if kind is bool:
        return not key.default
    if kind is int:
        return key.default + 1
    if kind is float:
        low, high = key.meta.ge or key.meta.gt or 0, key.meta.le or key.meta.lt
        return (key.default + low) / 2 if key.default > low else (key.default + high) / 2
    return TEXTS[name]


def nested(name: str, value: Any) -> dict[str, Any]:
    """Return nested dictionaries: ``a.b`` and 1 give ``{"a": {"b": 1}}``."""
    for part in reversed(name.split(".")):
        value = {part: value}
    return value


def merged(one: dict[str, Any], other: dict[str, Any]) -> dict[str, Any]:
    """Return nested dictionaries in one; the values of the other count."""
    both = {name: merged(one[name], other[name]) for name in one if isinstance(one[name], dict) and name in other}
    return {**one, **other, **both}


KEYS = [(key, key.name.replace("<name>", "rooms")) for key in keys_of(Configuration)]


@pytest.mark.slow
@pytest.mark.parametrize(("key", "name"), KEYS, ids=[name for _, name in KEYS])
def test_a_key_changes_some_job(key: Key, name: str, jobs_of: Callable[[dict[str, Any]], Jobs]) -> None:
    base = base_of(name)
    changed = merged(base, nested(name, other_value(key, name)))
    before, after = jobs_of(base), jobs_of(changed)
    rules = {jobs[path][0] for path in changed_jobs(before, after) for jobs in (before, after) if path in jobs}
    assert RULES[max((group for group in RULES if f"{name}.".startswith(f"{group}.")), key=len)] <= rules


@pytest.mark.parametrize(
    ("name", "value", "products"),
    [
        ("measures.window", 11, {
            "tables/per_seed.csv", "claims.csv", "figures/figure13.png", "explorer.html",
        }),
        ("measures.threshold_factor", 2.0, {
            "tables/per_seed.csv", "claims.csv", "figures/figure13.png",
        }),
        ("growth.breakpoint", 6, {"claims.csv", "figures/figure14.png"}),
        *[
            (f"statistics.{name}", value, {
                "tables/metrics.csv", "claims.csv", "figures/figure04.png",
                "figures/figure12.png", "figures/figure14.png",
                })
            for name, value in [("confidence", 0.9), ("resamples", 300)]
        ],
    ],
)  # fmt: skip
def test_a_key_of_measuring_acts_in_every_product(
    name: str, value: Any, products: set[str], jobs_of: Callable[[dict[str, Any]], Jobs]
) -> None:
    changed = changed_jobs(jobs_of({}), jobs_of(nested(name, value)))
    folders = ("reports/tiny/", "results/tiny/")
    assert products <= {path.removeprefix(folder) for path in changed for folder in folders}


def test_environments_of_the_tiny_run_can_be_taken_away(jobs_of: Callable[[dict[str, Any]], Jobs]) -> None:
    without = jobs_of({"environments": {"again": None}})
    assert without and not [path for path in without if "again" in path]
    assert [path for path in jobs_of({}) if "again" in path]
