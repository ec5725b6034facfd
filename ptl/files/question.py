"""The question that a run asks, and whether a result file answers it.

A file records what it was made from: parameters, root seed, map, tasks, seed and code. A job of the workflow gets the
question of its run, a part for each kind of file that it reads, and `read_file` refuses an answer to another one. So
neither times nor what Snakemake remembers decide which numbers belong together.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ptl.errors import UserError
from ptl.files.outside import RECORD, learning_code
from ptl.files.provenance import LEARNING_PACKAGES, code_digest
from ptl.files.remedies import force, make_again
from ptl.files.schema import FIT, FREQUENCIES, GAIN, GROWTH, LEARNING, LIVES, SETTING, STEPS
from ptl.keys import shortened
from ptl.methods import by_identifier, names
from ptl.methods.beyond import module_of
from ptl.world.gridworld import map_digest

if TYPE_CHECKING:
    from ptl.files.hdf5 import Node

READS = {
    LEARNING: ("learning", "skills", "subgoals", "policy_reuse"),
    GROWTH: ("learning", "skills", "subgoals"),
    FREQUENCIES: ("learning",),
}
"""Groups of hyper-parameters that each kind of job depends on."""

RULES = {
    LEARNING: "learn", GROWTH: "grow", FREQUENCIES: "survey_batch", GAIN: "learn_fv", SETTING: "decide",
    LIVES: "learn_lives",
}  # fmt: skip
"""Rules that make each kind of file."""

MISLEADING, POLICY_REUSE = "misleading_prior", "fernandez_veloso"
"""Side studies of the article's run, and their folders below results/<run>/."""

SIDE_MAPS = {MISLEADING: "config/misleading_prior.txt", POLICY_REUSE: "config/environments/env3.txt"}
"""Their maps."""

SIDE_TASKS = "ABC"
"""Tasks on the misleading map."""

FOLDERS = (
    "learning", "growth", "subgoal_frequencies", MISLEADING, POLICY_REUSE, "robustness", "decision",
    "lives",
)  # fmt: skip
"""Folders below results/<run>/ that hold files of one kind."""

NAMED_BY = {GAIN: "arm", SETTING: "setting", FIT: "setting", LIVES: "place"}
"""Attribute that gives a file its name."""

Question = Mapping[str, Mapping[str, Any]]
"""What the files of each kind must have been made from, by format; JSON."""

_asked: ContextVar[Question] = ContextVar("asked", default={})  # noqa: B039 - never changed


def digest_of(*parts: Any) -> str:
    """Return a digest of values that JSON can hold, and of their order."""
    return hashlib.sha256(json.dumps(parts).encode()).hexdigest()[:16]


def question_of(
    config: Mapping[str, Any], maps: Mapping[str, str], codes: Mapping[str, str] | None = None
) -> dict[str, dict[str, Any]]:
    """Return the question of a run.

    Parameters
    ----------
    config : mapping
        The completed configuration.
    maps : mapping
        Digest of the map of each environment, and of the side studies' maps.
    codes : mapping, optional
        Digest of the sources of each method as they are now; without it files by methods from elsewhere may be older.
    """
    common = {"root_seed": config["root_seed"]}
    environments, growth, survey = config["environments"], config["growth"], config["subgoal_frequencies"]
    asked = {kind: {**common, "parameters": {name: config[name] for name in names}} for kind, names in READS.items()}
    asked[LEARNING]["tasks"] = {name: entry["tasks"] for name, entry in environments.items()}
    asked[LEARNING]["tasks"][MISLEADING] = SIDE_TASKS
    asked[LEARNING]["maps"] = {name: maps[name] for name in (*environments, MISLEADING) if name in maps}
    asked[LEARNING]["methods"] = {
        name: {
            "reference": reference,
            "parameters": config["method_parameters"].get(name, {}),
            **({"code": codes[name]} if codes else {}),
        }
        for name, reference in by_identifier(config["methods"]).items()
    }
    asked[GROWTH]["maps"] = {growth["environment"]: maps[growth["environment"]]}
    asked[GROWTH]["number"] = growth["tasks"]
    asked[FREQUENCIES]["maps"] = {name: maps[name] for name in environments}
    asked[FREQUENCIES]["trajectories"] = survey["trajectories"]
    asked[FREQUENCIES]["number"] = survey["starts"]
    asked[GAIN] = {**common, "number": config["seeds"], "maps": {POLICY_REUSE: maps.get(POLICY_REUSE)}}
    return json.loads(json.dumps(asked))


def about(
    question: Mapping[str, Any], environments: Iterable[str], methods: Iterable[str] | None = None
) -> dict[str, Any]:
    """Return what a question for one kind of file asks of some environments and methods, and of the side studies."""
    kept = {*environments, *SIDE_MAPS}
    parts = {name: kept for name in ("maps", "tasks") if name in question}
    if methods is not None and "methods" in question:
        parts["methods"] = {*methods}
    return {
        **question,
        **{part: {k: v for k, v in question[part].items() if k in kept} for part, kept in parts.items()},
    }


def asked_jobs(kind: str, jobs: Mapping[str, Any], **shared: Any) -> dict[str, dict[str, Any]]:
    """Return the question that files of whole jobs answer: settings, and lives of the second study.

    Parameters
    ----------
    jobs : mapping
        Job of each file by the file's name.
    **shared
        What all jobs have in common; ``maps`` has the digest of each environment's map.
    """
    return json.loads(json.dumps({kind: {"jobs": jobs, **shared}}))


@contextmanager
def asking(question: Question) -> Iterator[None]:
    """Refuse, within the block, every file that answers another question when it is read."""
    token = _asked.set(question)
    try:
        yield
    finally:
        _asked.reset(token)


def check_answer(path: Path, root: Node) -> None:
    """Refuse a file that answers another question than the one asked now.

    Raises
    ------
    UserError
        Naming the file, what it was made with, and the command that makes all such files again.
    """
    asked = _asked.get().get(root.attrs["format"])
    if asked is None:
        return
    for fault in misplaced(path, root):
        raise UserError(f"{path}: {fault}; {make_again(path)}")
    for fault in _other_question(root, asked):
        raise UserError(f"{path}: {fault}; {anew(path, root)}")
    for fault in code_faults(root):
        raise UserError(f"{path}: {fault}; {anew(path, root)}")


def anew(path: Path, root: Node) -> str:
    """Return the remedy for a file that answers another question; others of its kind will too."""
    folder = path.absolute().parent.name
    rule = {MISLEADING: "learn_misleading", "robustness": "learn_setting"}.get(folder) or RULES[root.attrs["format"]]
    return force(path, rule)


# -- settings, map and work ---------------------------------------------------------------------------------------


def _other_question(root: Node, asked: Mapping[str, Any]) -> Iterator[str]:
    """Yield in what a file differs from what was asked."""
    attrs, kind = root.attrs, root.attrs["format"]
    if "jobs" in asked:
        yield from _other_job(attrs, asked, attrs[NAMED_BY[kind]])
        return
    if attrs["root_seed"] != asked["root_seed"]:
        yield f"was made with the root_seed {attrs['root_seed']}, not {asked['root_seed']}"
    for group, values in asked.get("parameters", {}).items():
        found = attrs["parameters"].get(group, {})
        for name in values:
            if found.get(name) != values[name]:
                yield f"was made with {group}.{name} {found.get(name)!r}, not {values[name]!r}"
    environment = POLICY_REUSE if kind == GAIN else attrs["environment"]
    if environment not in asked["maps"]:
        yield f"is of the environment {environment}, which is not in the run"
    elif asked["maps"][environment] != map_digest(attrs["map"]):
        yield "was made on another map"
    if "methods" in asked and environment not in SIDE_MAPS:
        yield from _other_method(attrs, asked["methods"].get(attrs["method"]))
    for name, found, wanted in _work(root, asked):
        if found != wanted:
            yield f"holds {name} {found}, not {wanted}"


def _other_method(attrs: Mapping[str, Any], asked: Mapping[str, Any] | None) -> Iterator[str]:
    name = attrs["method"]
    if asked is None:
        yield f"is of the method {name}, which is not in the run"
        return
    record = attrs["parameters"].get(RECORD, {})
    if (found := record.get("reference", name)) != asked["reference"]:
        yield f"was made by the method {found}, not by {asked['reference']}"
    if (own := record.get("parameters", {})) != (wanted := asked["parameters"]):
        yield f"was made with {name}'s parameters {shortened(str(own))}, not {shortened(str(wanted))}"
    if attrs["code"] != asked.get("code", attrs["code"]):
        yield f"was made by another version of the method {name}"


def _work(root: Node, asked: Mapping[str, Any]) -> Iterator[tuple[str, Any, Any]]:
    """Yield the name of each kind of work, how much a file holds, and how much was asked for."""
    kind = root.attrs["format"]
    if kind == LEARNING:
        yield "tasks", "".join(root["tasks"]), asked["tasks"].get(root.attrs["environment"])
    elif kind == GROWTH:
        yield "tasks", len(root["starts"]), asked["number"]
    elif kind == GAIN:
        yield "seeds", len(root["seeds"]), asked["number"]
    else:
        yield "trajectories", root.attrs["trajectories"], asked["trajectories"]
        states = len(root["counts"])
        wanted = states if asked["number"] == "all" else min(asked["number"], states)
        yield "starts", root.attrs["starts"], wanted


def _other_job(attrs: Mapping[str, Any], asked: Mapping[str, Any], named: str) -> Iterator[str]:
    if named not in asked["jobs"]:
        yield f"holds the job {named}, which is not in the run"
        return
    wanted = {name: value for name, value in asked.items() if name not in {"jobs", "maps"}} | asked["jobs"][named]
    if wanted.pop("code", attrs["code"]) != attrs["code"]:
        yield "was made by another version of its method"
    for name in wanted:
        if attrs["job"].get(name) != wanted[name]:
            yield f"was made with another value of {name}"
    for environment, text in attrs.get("maps", {}).items():
        entry = wanted["environments"].get(environment, {})
        if not entry.get("changes") and asked["maps"].get(environment) != map_digest(text):
            yield f"was made on another map of {environment}"


# -- code ---------------------------------------------------------------------------------------------------------


def code_faults(root: Node) -> Iterator[str]:
    """Yield a fault if a file was not made by the sources as they are now, or by a method that is gone."""
    attrs, kind = root.attrs, root.attrs["format"]
    if "code" not in attrs:
        return
    if kind == LIVES:
        module = module_of(str(attrs["job"]["cell"].get("method")))
        if not module:  # another's method may have changed
            return
        present = lives_code(module)
    elif kind == SETTING:
        if gone := [method for method in attrs["job"]["methods"] if method not in names()]:
            yield f"was made by the method {shortened(str(gone[0]))}, which is not there"
            return
        used = [f"ptl.methods.{method}" for method in attrs["job"]["methods"]]
        present = code_digest("ptl.study.robustness.running", *used)
    else:
        method = str(attrs.get("method", ""))
        outside = attrs["parameters"].get(RECORD)
        reference = str(outside["reference"]) if isinstance(outside, dict) and "reference" in outside else method
        if reference != method and not reference.endswith(".py"):
            return  # nothing that a file names is imported
        there = reference in names() if reference == method else Path(reference).is_file()
        if reference and not there:
            yield f"was made by the method {reference}, which is not there"
            return
        present = _present_code(kind, reference)
    if attrs["code"] != present:
        yield "was made by another version of the code"


@cache
def _present_code(kind: str, method: str) -> str:
    if kind == LEARNING:
        return learning_code(method)
    if kind == GROWTH:
        return code_digest("ptl.learning.growth", f"ptl.methods.{method}")
    if kind == GAIN:
        return code_digest("ptl.study.policy_reuse_experiment", "ptl.methods.policy_reuse", "ptl.methods.no_transfer")
    return code_digest("ptl.learning.survey")


def lives_code(*modules: str) -> str:
    """Return a digest of the sources that lives of the second study depend on, a method's own ones included."""
    running = "ptl.study.population.running"
    return code_digest(running, *modules, within=(*LEARNING_PACKAGES, running))


# -- place --------------------------------------------------------------------------------------------------------


def misplaced(path: Path, root: Node) -> Iterator[str]:
    """Yield a fault if a file is not where the layout of results/<run>/ puts its job."""
    parts = path.absolute().parts
    folders = parts[-4:-1]  # not the folders above the project
    attrs, kind = root.attrs, root.attrs["format"]
    expected: tuple[str, ...] = ()
    if kind == LEARNING and folders[-1] == MISLEADING:
        expected = (attrs["environment"], f"seed_{attrs['seed']:03d}.h5")
    elif kind == LEARNING and "learning" in folders:
        expected = (attrs["environment"], attrs["method"], f"seed_{attrs['seed']:03d}.h5")
    elif kind == GROWTH and folders[-1] == "growth":
        expected = (f"run_{attrs['seed']:03d}.h5",)
    elif kind == FREQUENCIES and "subgoal_frequencies" in folders:
        batch = attrs.get("batch")
        name = attrs["environment"]
        expected = (f"{name}.h5",) if batch is None else (name, f"batch_{batch}.h5")
    elif kind in NAMED_BY:
        expected = Path(f"{attrs[NAMED_BY[kind]]}.h5").parts
    elif kind == STEPS:
        expected = ("steps.h5",)
    elif parts[-1] == "steps.h5" or any(folder in folders for folder in FOLDERS):
        yield f"is of the kind {kind}, which does not belong in this folder"
    if expected and parts[-len(expected) :] != expected:
        yield f"holds the job {'/'.join(expected)}"
