"""From a setting's raw file to the verdict on every claim, by the very checks of the main run's ledger."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from ptl import claims, measures
from ptl.claims import comparisons
from ptl.claims.claim import Judgement
from ptl.claims.verdict import Outcome
from ptl.evidence import Evidence, Lacking
from ptl.gridworld import GridWorld
from ptl.robustness.design import REFERENCE
from ptl.robustness.running import read_setting
from ptl.statistics import Resampling

NOT_VARIED = {
    "selection-cost": "time of one selection, in which no unknown enters",
    "space": "bytes of a library, in which no unknown enters",
}
"""Claims that the study leaves out, and why."""

BASE = "no_transfer"


@dataclass(frozen=True)
class RawSetting:
    """A raw file of the study, turned into what verdicts look at."""

    name: str
    group: str
    changes: dict[str, Any]
    status: str
    evidence: Evidence
    truncated: int
    total_steps: int


def load_setting(path: str | Path, window: int, threshold_factor: float, how: Resampling) -> RawSetting:
    """Read a raw file and measure it.

    Parameters
    ----------
    window, threshold_factor
        As for `ptl.measures.measure_files`.
    how : Resampling
        Of the verdicts' intervals.

    Raises
    ------
    UserError
        When the file is missing, damaged or of another kind.
    """
    arrays, origin = read_setting(path)
    job = origin["job"]
    worlds = {name: GridWorld.from_text(text, name) for name, text in origin["maps"].items()}
    runs = [
        (environment, method)
        for environment in job["environments"]
        for method in job["methods"]
        if f"{environment}/{method}/steps" in arrays
    ]
    letters = {environment: entry["tasks"] for environment, entry in job["environments"].items()}
    per_seed, subgoals, curves = [], [], {}
    for environment, method in runs:
        world = worlds[environment]
        own = {
            key.rpartition("/")[2]: value for key, value in arrays.items() if key.startswith(f"{environment}/{method}/")
        }
        base = arrays.get(f"{environment}/{BASE}/steps")
        for index, letter in enumerate(letters[environment]):
            steps = own["steps"][:, index]
            curves[environment, method, letter] = steps
            shortest = world.shortest_path_length(world.start, world.goal(letter))
            paired = None if base is None else base[: len(steps), index]
            frame = _measures(steps, paired, shortest, window, threshold_factor)
            names = {"environment": environment, "task": letter, "method": method, "seed": own["seeds"]}
            per_seed.append(frame.assign(**names, truncated=own["truncated"][:, index]))
            if "subgoal" in own:
                subgoals.append(_subgoals(own, index, world).assign(**names))
    evidence = Evidence(
        per_seed=pd.concat(per_seed, ignore_index=True)[list(measures.PER_SEED_COLUMNS)] if per_seed else _nothing(),
        worlds=worlds,
        steps=curves,
        subgoals=pd.concat(subgoals, ignore_index=True)[list(measures.SUBGOAL_COLUMNS)] if subgoals else None,
        growth=_growth(arrays["growth/library_size"]) if "growth/library_size" in arrays else None,
        how=how,
    )
    return RawSetting(
        job["setting"],
        job["group"],
        job["changes"],
        str(origin["status"]),
        evidence,
        truncated=_total(arrays, "/truncated"),
        total_steps=_total(arrays, "/steps"),
    )


def _total(arrays: Mapping[str, np.ndarray], ending: str) -> int:
    return sum(int(array.sum()) for name, array in arrays.items() if name.endswith(ending))


def _measures(steps: np.ndarray, base: np.ndarray | None, shortest: int, window: int, factor: float) -> pd.DataFrame:
    # a base that was given up has fewer seeds: then nothing is compared
    jump = ratio = np.full(len(steps), np.nan)
    if base is not None and len(base) == len(steps):
        jump, ratio = measures.jump_start(steps, base), measures.transfer_ratio(steps, base)
    return pd.DataFrame(
        {
            "first_episode": measures.first_episode(steps),
            "asymptotic": measures.asymptotic(steps, window),
            "threshold_episode": measures.threshold_episode(steps, shortest, window, factor),
            "total_steps": measures.total_steps(steps),
            "jump_start": jump,
            "transfer_ratio": ratio,
        }
    )


def _subgoals(own: Mapping[str, np.ndarray], index: int, world: GridWorld) -> pd.DataFrame:
    subgoal = own["subgoal"][:, index]
    cells = np.where((subgoal >= 0)[:, None], world.cells[subgoal], -1)
    return pd.DataFrame(
        {
            "subgoal": subgoal,
            "row": pd.array(np.where(subgoal >= 0, cells[:, 0], -1), dtype="Int64"),
            "column": pd.array(np.where(subgoal >= 0, cells[:, 1], -1), dtype="Int64"),
            "novelty": own["novelty"][:, index],
            "metric_value": own["incremental_value"][:, index],
            "reason": [reason.decode() for reason in own["reason"][:, index]],
            "incremental_peak": own["incremental_peak"][:, index],
            "original_peak": own["original_peak"][:, index],
        }
    ).assign(row=lambda f: f["row"].mask(f["subgoal"] < 0), column=lambda f: f["column"].mask(f["subgoal"] < 0))


def _growth(sizes: np.ndarray) -> pd.DataFrame:
    runs, points = sizes.shape
    return pd.DataFrame(
        {
            "run": np.repeat(np.arange(runs), points),
            "tasks": np.tile(np.arange(points), runs),
            "library_size": sizes.ravel(),
        }
    )


def _nothing() -> pd.DataFrame:
    return pd.DataFrame(columns=list(measures.PER_SEED_COLUMNS))


# -- verdicts ------------------------------------------------------------------------------------------------


def judge(setting: RawSetting) -> list[Judgement]:
    """The verdict on every claim that an unknown can change."""
    return [claim.judge(setting.evidence) for claim in claims.CLAIMS if claim.id not in NOT_VARIED]


def verdict_frame(setting: RawSetting) -> pd.DataFrame:
    """One row a claim.

    Columns setting, group, changes (JSON), status, truncated (episodes), total_steps, claim, verdict, parts
    (comparisons that the claim is made of), parts_holding, evidence (those comparisons with their intervals).
    """
    judgements = judge(setting)
    return pd.DataFrame(
        {
            "setting": setting.name,
            "group": setting.group,
            "changes": json.dumps(setting.changes),
            "status": setting.status,
            "truncated": setting.truncated,
            "total_steps": setting.total_steps,
            "claim": [judgement.claim.id for judgement in judgements],
            "verdict": [str(judgement.verdict) for judgement in judgements],
            "parts": [len(judgement.parts) for judgement in judgements],
            "parts_holding": [
                sum(part.outcome is Outcome.HOLDS for part in judgement.parts) for judgement in judgements
            ],
            "evidence": [
                "; ".join(map(str, judgement.parts)) if judgement.parts else judgement.reason
                for judgement in judgements
            ],
        }
    )


# -- numbers behind single claims ----------------------------------------------------------------------------


@dataclass(frozen=True)
class Target:
    """A claim that the reference setting does not reproduce, and where its cause is looked for.

    Attributes
    ----------
    claim, environment : str
    unknowns : tuple of str
        Keys of the unknowns that might be the cause.
    tasks : str or None
        Letters of the tasks shown; those after the first if None.
    methods : tuple of str
        Methods shown, with no transfer beside them.
    """

    claim: str
    environment: str
    unknowns: tuple[str, ...]
    tasks: str | None
    methods: tuple[str, ...]


PTL_VARIANTS = ("ptl", "ptl_supervised", "ptl_unknown_goal")

TARGETS = (
    Target(
        "E3-jump",
        "env3",
        ("env3.start", "skills.prior_width", "skills.prior_form", "skills.skill_use", "skills.null_skill"),
        None,
        PTL_VARIANTS,
    ),
    Target(
        "E3-few",
        "env3",
        ("policy_reuse.temperature_step", "policy_reuse.psi_decay", "env3.start"),
        "F",
        ("full_transfer", "policy_reuse", *PTL_VARIANTS),
    ),
)

TARGET_COLUMNS = (
    "claim", "setting", "group", "changes", "environment", "task", "method", "seeds", "first_episode",
    "base_first_episode", "jump_start_percent", "jump_start_low", "jump_start_high", "episodes",
    "episodes_low", "episodes_high", "reached", "total_steps",
)  # fmt: skip


def target_frame(setting: RawSetting) -> pd.DataFrame:
    """What a setting says about the claims of `TARGETS` it is an experiment for, one row a task and method.

    Columns `TARGET_COLUMNS`: means over seeds; jump start in % of the base's mean first episode, and episodes
    to the threshold (a run that never reaches it counts with all its episodes), both with bootstrap intervals
    as in the ledger. No row for a setting that is an experiment for none of the claims.
    """
    rows = []
    for target in TARGETS:
        single = len(setting.changes) == 1 and set(setting.changes) <= set(target.unknowns)
        if setting.group != REFERENCE and not single:
            continue
        per_seed = setting.evidence.per_seed
        own = per_seed[per_seed["environment"] == target.environment]
        for letter in target.tasks or sorted(set(own["task"]))[1:]:
            for method in target.methods:
                names = (target.environment, letter, method)
                try:
                    numbers = _target_numbers(setting.evidence, *names)
                except Lacking:
                    continue  # the status of the setting says why
                rows.append(
                    {"claim": target.claim, "setting": setting.name, "group": setting.group,
                     "changes": json.dumps(setting.changes), "environment": target.environment,
                     "task": letter, "method": method} | numbers
                )  # fmt: skip
    return pd.DataFrame(rows, columns=list(TARGET_COLUMNS))


def _target_numbers(evidence: Evidence, environment: str, task: str, method: str) -> dict[str, object]:
    first, base = evidence.pair((environment, task, method), (environment, task, BASE), "first_episode")
    saved = comparisons.saved_percent(evidence, environment, task, method, "first_episode")
    episodes = comparisons.mean_episodes(evidence, environment, task, method)
    return {
        "seeds": len(first),
        "first_episode": first.mean(),
        "base_first_episode": base.mean(),
        "jump_start_percent": saved.value,
        "jump_start_low": saved.low,
        "jump_start_high": saved.high,
        "episodes": episodes.value,
        "episodes_low": episodes.low,
        "episodes_high": episodes.high,
        "reached": np.isfinite(evidence.values(environment, task, method, "threshold_episode")).mean(),
        "total_steps": evidence.values(environment, task, method, "total_steps").mean(),
    }
