"""From a setting's file to the verdict on every claim, by the checks of the main run's ledger."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from ptl import claims
from ptl.claims import comparisons
from ptl.claims.claim import Judgement
from ptl.claims.evidence import Evidence, MissingEvidence, settings_of
from ptl.claims.verdict import Outcome
from ptl.files.store import Result
from ptl.measures.measures import BASE, Runs, measure, runs_of
from studies.robustness.design import REFERENCE
from studies.robustness.jobs import lives_in
from studies.robustness.running import changed_worlds

NOT_VARIED = {
    "selection-cost": "operations of one selection, in which no unknown enters",
    "space": "bytes of a library, in which no unknown enters",
}
"""Claims that the study leaves out, and why."""


@dataclass(frozen=True)
class SettingEvidence:
    """A setting as evidence for claims.

    Attributes
    ----------
    name, group : str
    changes : dict
        Changed unknowns with their values.
    status : str
    evidence : Evidence
    """

    name: str
    group: str
    changes: dict[str, Any]
    status: str
    evidence: Evidence


def evidence_of(result: Result, groups: Any) -> SettingEvidence:
    """Measure the file of a setting.

    Parameters
    ----------
    groups : namespace
        Groups measures, statistics and growth of the configuration, see `ptl.claims.evidence.settings_of`.
    """
    job = result.job
    lives = lives_in(result.arrays)
    runs: list[Runs] = []
    for environment, letters in job.tasks.items():
        for method in job.methods:
            if (environment, method) in lives:
                runs += runs_of(environment, method, letters, lives[environment, method])
    worlds = changed_worlds(result.worlds, job.changes) if lives else {}
    measured = measure(runs, worlds, groups.measures.window, groups.measures.threshold_factor)
    evidence = Evidence(
        per_seed=measured.per_seed,
        worlds=worlds,
        steps=measured.steps,
        subgoals=measured.subgoals,
        growth=result.arrays.get("growth/library_size"),
        **settings_of(groups),
    )
    status = result.arrays["status"].item().decode()
    return SettingEvidence(job.name, job.group, job.changes, status, evidence)


# -- verdicts ------------------------------------------------------------------------------------------------


def judge(setting: SettingEvidence) -> list[Judgement]:
    """Return the verdict on every claim that an unknown can change."""
    return [claim.judge(setting.evidence) for claim in claims.CLAIMS if claim.id not in NOT_VARIED]


def verdict_frame(setting: SettingEvidence) -> pd.DataFrame:
    """Return a row for each claim.

    Columns setting, group, changes (JSON), status, truncated (episodes), total_steps, claim, verdict, parts
    (comparisons that the claim is made of), parts_holding, evidence (those comparisons with their intervals).
    """
    judgements, per_seed = judge(setting), setting.evidence.per_seed
    return pd.DataFrame(
        {
            "setting": setting.name,
            "group": setting.group,
            "changes": json.dumps(setting.changes),
            "status": setting.status,
            "truncated": int(per_seed["truncated"].sum()),
            "total_steps": int(per_seed["total_steps"].sum()),
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
    """A claim that the reference setting does not reproduce, and the unknowns that may be the cause.

    Attributes
    ----------
    claim, environment : str
    unknowns : tuple of str
        Keys of the unknowns that might be the cause.
    tasks : str or None
        Letters of the tasks shown; those after the first if None.
    methods : tuple of str
        Methods shown, in addition to no transfer.
    """

    claim: str
    environment: str
    unknowns: tuple[str, ...]
    tasks: str | None
    methods: tuple[str, ...]


TARGETS = (
    Target(
        "E3-jump",
        "env3",
        ("env3.start", "skills.prior_width", "skills.prior_form", "skills.skill_use", "skills.null_skill"),
        None,
        comparisons.VARIANTS,
    ),
    Target(
        "E3-few",
        "env3",
        ("policy_reuse.temperature_step", "policy_reuse.psi_decay", "env3.start"),
        "F",
        (comparisons.FULL, comparisons.REUSE, *comparisons.VARIANTS),
    ),
)

TARGET_COLUMNS = (
    "claim", "setting", "group", "changes", "environment", "task", "method", "seeds", "first_episode",
    "base_first_episode", "jump_start_percent", "jump_start_low", "jump_start_high", "episodes",
    "episodes_low", "episodes_high", "reached", "total_steps",
)  # fmt: skip


def target_frame(setting: SettingEvidence) -> pd.DataFrame:
    """Return the numbers behind the claims of `TARGETS` in a setting that tests them, a row for each task and method.

    Columns `TARGET_COLUMNS`: means over seeds; jump start in % of the base's mean first episode, and episodes to the
    threshold (a run that never reaches it counts with all its episodes), both with bootstrap intervals as in the
    ledger. A setting that tests none of the claims gives no row.
    """
    rows = []
    for target in TARGETS:
        single = len(setting.changes) == 1 and set(setting.changes) <= set(target.unknowns)
        if setting.group != REFERENCE and not single:
            continue
        per_seed = setting.evidence.per_seed
        own = per_seed[per_seed["environment"] == target.environment]
        for letter in target.tasks or own["task"].unique()[1:]:
            for method in target.methods:
                names = (target.environment, letter, method)
                try:
                    numbers = _target_numbers(setting.evidence, *names)
                except MissingEvidence:
                    continue  # the status of the setting records the reason
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
