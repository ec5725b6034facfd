"""From a setting's raw file to the verdict on every claim, by the very checks of the main run's ledger."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from ptl import claims, measures
from ptl.claims.claim import Judgement
from ptl.evidence import Evidence
from ptl.gridworld import GridWorld
from ptl.robustness.design import REFERENCE
from ptl.robustness.running import read_setting
from ptl.statistics import Resampling, mean, named_generator

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
        own = {key.rpartition("/")[2]: value for key, value in arrays.items() if key.startswith(f"{environment}/{method}/")}
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
    steps = [array for name, array in arrays.items() if name.endswith("/steps")]
    truncated = [array for name, array in arrays.items() if name.endswith("/truncated")]
    return RawSetting(
        job["setting"],
        job["group"],
        job["changes"],
        str(origin["status"]),
        evidence,
        truncated=int(sum(array.sum() for array in truncated)),
        total_steps=int(sum(array.sum() for array in steps)),
    )


def _measures(
    steps: np.ndarray, base: np.ndarray | None, shortest: int, window: int, factor: float
) -> pd.DataFrame:
    # a base that was given up has fewer seeds: the comparison is missing where there is nothing to compare with
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


# -- verdicts ---------------------------------------------------------------------------------------------------------


def judge(setting: RawSetting) -> list[Judgement]:
    """The verdict on every claim that an unknown can change."""
    return [claim.judge(setting.evidence) for claim in claims.CLAIMS if claim.id not in NOT_VARIED]


def verdict_frame(setting: RawSetting) -> pd.DataFrame:
    """One row a claim: setting, group, changes (JSON), status, truncated, total_steps, claim, verdict, evidence."""
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
            "evidence": [
                "; ".join(map(str, judgement.parts)) if judgement.parts else judgement.reason
                for judgement in judgements
            ],
        }
    )


# -- numbers behind single claims -------------------------------------------------------------------------------------

TARGETS = {
    "E3-jump": ("env3", ("env3.start", "skills.prior_width", "skills.prior_form", "skills.skill_use")),
    "E3-few": ("env3", ("policy_reuse.temperature_step", "policy_reuse.psi_decay")),
}
"""Claims that were not reproduced at first, their environment, and the unknowns that might be the cause."""


def targets_of(setting: RawSetting) -> list[str]:
    """Claims for which a setting is a targeted experiment; replicates of the reference are one for all of them."""
    if setting.group == REFERENCE:
        return list(TARGETS)
    if len(setting.changes) != 1:
        return []
    return [claim for claim, (_, unknowns) in TARGETS.items() if set(setting.changes) <= set(unknowns)]


def target_frame(setting: RawSetting, methods: Sequence[str], task: str = "F") -> pd.DataFrame:
    """Jump start, time to threshold and total steps of a targeted setting, one row a claim, task and method.

    Jump start is given for every task with something to transfer; columns setting, changes (JSON), claim, environment,
    task, method, seeds, first_episode, jump_start with its interval, jump_start_percent (of the base's mean),
    threshold_median (episodes; seeds that never reach it count as later than all), reached (share), total_steps.
    """
    rows = []
    per_seed = setting.evidence.per_seed
    for claim in targets_of(setting):
        environment = TARGETS[claim][0]
        own = per_seed[(per_seed["environment"] == environment) & per_seed["method"].isin(methods)]
        tasks = sorted(set(own["task"]))[1:] if claim == "E3-jump" else [task]
        for (letter, method), part in own[own["task"].isin(tasks)].groupby(["task", "method"], sort=False):
            base = per_seed[
                (per_seed["environment"] == environment) & (per_seed["task"] == letter) & (per_seed["method"] == BASE)
            ]
            names = ("robustness", setting.name, environment, str(letter), str(method))
            jump = mean(part["jump_start"].to_numpy(float), setting.evidence.how, named_generator(*names, "jump_start"))
            threshold = part["threshold_episode"].fillna(np.inf)
            rows.append(
                {
                    "setting": setting.name,
                    "changes": json.dumps(setting.changes),
                    "claim": claim,
                    "environment": environment,
                    "task": letter,
                    "method": method,
                    "seeds": len(part),
                    "first_episode": part["first_episode"].mean(),
                    "jump_start": jump.value,
                    "jump_start_low": jump.low,
                    "jump_start_high": jump.high,
                    "jump_start_percent": 100 * jump.value / base["first_episode"].mean() if len(base) else np.nan,
                    "threshold_median": threshold.median() if np.isfinite(threshold.median()) else np.nan,
                    "reached": part["threshold_episode"].notna().mean(),
                    "total_steps": part["total_steps"].mean(),
                }
            )
    return pd.DataFrame(rows)
