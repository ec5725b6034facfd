"""The decision: the run's claims on many more seeds than its tables have, learned in few jobs.

A job is a setting of `ptl.study.robustness.running` with the run's own parameters and one method in one environment, so
its random numbers are others than those of the tables: a claim is decided by runs that the tables do not show.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from ptl.config import Configuration, Parameters
from ptl.errors import UserError
from ptl.files.remedies import make_again
from ptl.study.claims.comparisons import FULL, OTHERS, VARIANTS
from ptl.study.claims.curves import ENVIRONMENTS
from ptl.study.evidence import Evidence
from ptl.study.measures import BASE
from ptl.study.robustness.running import COMPLETE
from ptl.study.robustness.verdicts import evidence_of

GROUP = "decision"
GROWTH = "growth"
"""Name of the job in which libraries grow."""


def decision_jobs(config: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    """Return the jobs by name, as `ptl.study.robustness.running.run_setting` takes them.

    Parameters
    ----------
    config : mapping
        The completed configuration of a run. Environments and methods that no claim speaks of have no job.
    """
    run = Configuration.from_dict(config)
    common = {
        "group": GROUP,
        "changes": {},
        "root_seed": run.root_seed,
        "parameters": {group: getattr(run, group).to_dict() for group in Parameters.__struct_fields__},
    }

    seeds = {FULL: run.decision.full_transfer_seeds, BASE: run.decision.no_transfer_seeds}

    def effort(number: int) -> dict[str, int]:
        return {"seeds": number, "step_budget": run.learning.max_steps * run.learning.episodes * number}

    environments = {
        name: {"map": entry.map, "tasks": entry.tasks, "changes": {}} for name, entry in run.environments.items()
    }
    growth = {"environment": run.growth.environment, "tasks": run.growth.tasks}
    jobs = {
        f"{name}_{method}": {
            "environments": {name: environments[name]},
            "methods": [method],
            "growth": growth | {"runs": 0},
            **effort(seeds.get(method, run.decision.seeds)),
        }
        for name in environments
        if name in ENVIRONMENTS
        for method in run.methods
        if method in (*OTHERS, *VARIANTS)
    }
    if run.growth.environment in ENVIRONMENTS:
        jobs[GROWTH] = {
            "environments": {run.growth.environment: environments[run.growth.environment]},
            "methods": [],
            "growth": growth | {"runs": run.decision.growth_runs},
            **effort(run.decision.seeds),
        }
    return {name: {"setting": name, **common, **job} for name, job in jobs.items()}


def read_decision(paths: Iterable[str | Path], groups: Any, **tables: Any) -> Evidence:
    """Read the files of all jobs as evidence; first episodes are compared with their exact expectation.

    Parameters
    ----------
    groups, tables
        As of `ptl.study.robustness.verdicts.evidence_of`.

    Raises
    ------
    UserError
        When a file cannot be read or its job did not finish.
    """
    paths = list(paths)
    evidence, origins = evidence_of(paths, groups, exact=True, **tables)
    for path, origin in zip(paths, origins, strict=True):
        if str(origin["status"]) != COMPLETE:
            raise UserError(f"{path}: the job did not finish ({origin['status']}); {make_again(path)}")
    return evidence
