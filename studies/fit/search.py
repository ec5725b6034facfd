"""The search for drawings and settings that fit the article's claims, over the values of config/fit.yaml.

A *learner* is a setting that all environments share, a *drawing* a map of one environment; both are changes against the
first reference. Environments do not depend on each other, so the best drawing of each is chosen by its own claims:

1. every drawing with the first few learners (the probes), of which the best few drawings go on;
2. every learner with these drawings; for each learner the best drawing of each environment;
3. every learner with its drawings on all claims: the *screen*. The best ones, the reference, and the best by either
   half of the claims are the finalists;
4. the finalists' learners with these drawings again, with other random numbers and more seeds, and for each the best
   drawing of each environment. The best finalist is the choice.

``python -m studies.fit.search`` runs it in one process. Parameters that a method does not read cannot change it, so
lives are learned once for all readings with the same values of the parameters that it reads.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pandas as pd

from ptl.claims import CLAIMS
from ptl.claims.claim import Claim, Judgement
from ptl.claims.evidence import Evidence
from ptl.claims.verdict import Outcome, Verdict
from ptl.config import Configuration, Parameters
from ptl.errors import UserError
from ptl.files.configuration import completed, read_yaml
from ptl.files.csv import write_csv
from ptl.learning.growth import METHOD as GROWTH_METHOD
from ptl.learning.lives import grow_lives, learn_lives
from ptl.measures.measures import Runs, measure, runs_of
from ptl.measures.statistics import Resampling
from ptl.world.drawing import changed_world
from ptl.world.gridworld import GridWorld, load_map

SEARCH, CONFIG, REPORTS = Path("studies/fit/config/fit.yaml"), Path("config/config.yaml"), Path("reports/fit")

STREAM = "fit"
"""First name of every random stream of the search; readings share their random numbers, stages do not."""

NOT_VARIED = ("selection-cost", "space")
"""Claims that no setting can change."""

IGNORED = {
    "no_transfer": ("skills.", "subgoals.", "policy_reuse."),
    "full_transfer": ("skills.", "subgoals.", "policy_reuse."),
    "policy_reuse": ("skills.", "subgoals."),
    "ptl": ("policy_reuse.",),
    "ptl_supervised": ("policy_reuse.", "skills.prior_", "skills.likelihood_"),
    "ptl_unknown_goal": ("policy_reuse.", "skills.prior_"),
}
"""Beginnings of the keys that a method does not read."""

Changes = Mapping[str, Any]


class Effort(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Effort of a stage: lives of each method in each environment, lives of the growing library, resamples."""

    seeds: int
    growth_runs: int
    resamples: int


class FirstReference(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The setting from which changes are counted: map files, and every key that a learner may change."""

    maps: dict[str, str]
    learner: dict[str, Any]


class Search(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Settings of the search, fixed in advance in config/fit.yaml, which explains each value."""

    screen: Effort
    final: Effort
    probes: int
    kept: int
    finalists: int
    max_steps: int
    reference: FirstReference
    drawings: dict[str, list[dict[str, Any]]]
    learners: list[dict[str, Any]]
    halves: list[list[str]]


# -- readings and scores ------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Reading:
    """A learner and the drawings of all environments or of some of them, as changes against the reference."""

    learner: Changes
    drawings: Mapping[str, Changes]

    @property
    def changes(self) -> int:
        """Number of values that differ from the reference: the less, the simpler."""
        return len(self.learner) + sum(bool(drawing) for drawing in self.drawings.values())


@dataclass(frozen=True)
class Judged:
    """A reading with the verdicts of a stage."""

    stage: str
    reading: Reading
    seeds: int
    judgements: tuple[Judgement, ...]

    def score(self, claims: Iterable[str] | None = None) -> tuple[int, int]:
        """Return the claims reproduced and the failing parts, of all claims judged or of those named."""
        wanted = None if claims is None else set(claims)
        judged = [own for own in self.judgements if wanted is None or own.claim.id in wanted]
        reproduced = sum(own.verdict is Verdict.REPRODUCED for own in judged)
        return reproduced, sum(part.outcome is Outcome.FAILS for own in judged for part in own.parts)

    def rank(self, claims: Iterable[str] | None = None) -> tuple[int, int, int]:
        """Return what the rule compares: claims reproduced, failing parts, changes; smaller is better."""
        reproduced, failing = self.score(claims)
        return -reproduced, failing, self.reading.changes


def best(judged: Sequence[Judged], claims: Sequence[str] | None = None) -> Judged:
    """Return the best reading by the rule, on all claims judged or on those named; the earlier of equals."""
    return min(judged, key=lambda own: own.rank(claims))


def claims_of(environment: str) -> list[Claim]:
    """Return the claims on one environment alone (``E1-...`` is on env1); the others need several."""
    return [claim for claim in CLAIMS if claim.id.startswith(f"E{environment.removeprefix('env')}-")]


# -- the search ---------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Outcomes:
    """All that was tried, in order, and the choices: by all claims, and by either half."""

    tried: list[Judged]
    choice: Judged
    by_half: list[Judged]
    reference: Judged


class Searcher:
    """Runs a search on top of a configuration, which gives all that the search does not vary."""

    def __init__(self, search: Search, config: Configuration) -> None:
        self.search, self.config = search, config
        self.tried: list[Judged] = []
        self.learned: dict[str, Any] = {}

    def run(self) -> Outcomes:
        """Go through all stages."""
        search = self.search
        learners: list[Changes] = [{}, *search.learners]
        kept = {name: self._kept_drawings(name, learners[: search.probes]) for name in self.config.environments}
        ranked = sorted((self._screened(learner, kept) for learner in learners), key=Judged.rank)
        by_half = [
            best([self._screened(learner, kept, half) for learner in learners], half).reading.learner
            for half in search.halves
        ]
        reference = Reading({}, {name: {} for name in self.config.environments})
        finals = [
            self._judge("final", reference, CLAIMS),
            *(self._decided(own.reading.learner, kept) for own in ranked[: search.finalists]),
        ]
        halves = [self._decided(learner, kept, half) for learner, half in zip(by_half, search.halves, strict=True)]
        return Outcomes(self.tried, best([*finals, *halves]), halves, finals[0])

    def _kept_drawings(self, environment: str, probes: Sequence[Changes]) -> list[Changes]:
        drawings: list[Changes] = [{}, *self.search.drawings.get(environment, [])]
        ranks = [
            best([self._on_one(learner, environment, drawing, "probe") for learner in probes]).rank()
            for drawing in drawings
        ]
        others = sorted(range(1, len(drawings)), key=ranks.__getitem__)
        return [drawings[place] for place in (0, *others[: self.search.kept])]

    def _screened(
        self, learner: Changes, kept: Mapping[str, list[Changes]], claims: Sequence[str] | None = None
    ) -> Judged:
        return self._judge("screen", self._best_drawings(learner, kept, claims, "drawings"), CLAIMS)

    def _decided(
        self, learner: Changes, kept: Mapping[str, list[Changes]], claims: Sequence[str] | None = None
    ) -> Judged:
        return self._judge("final", self._best_drawings(learner, kept, claims, "final drawings"), CLAIMS)

    def _best_drawings(
        self, learner: Changes, kept: Mapping[str, list[Changes]], claims: Sequence[str] | None, stage: str
    ) -> Reading:
        chosen = {}
        for name, drawings in kept.items():
            judged = [self._on_one(learner, name, drawing, stage) for drawing in drawings]
            chosen[name] = best(judged, claims).reading.drawings[name]
        return Reading(learner, chosen)

    def _on_one(self, learner: Changes, environment: str, drawing: Changes, stage: str) -> Judged:
        """Judge the claims on one environment alone."""
        return self._judge(stage, Reading(learner, {environment: drawing}), claims_of(environment))

    # -- judging ---------------------------------------------------------------------------------------------

    def _judge(self, stage: str, reading: Reading, claims: Iterable[Claim]) -> Judged:
        same = [own for own in self.tried if own.reading == reading and _phase(own.stage) == _phase(stage)]
        done = next((own for own in same if own.stage == stage), None)
        if done is None:
            judgements = same[0].judgements if same else self._judgements(stage, reading, claims)
            done = Judged(stage, reading, self._effort(stage).seeds, judgements)
            self.tried.append(done)
        return done

    def _effort(self, stage: str) -> Effort:
        return self.search.final if _phase(stage) == "final" else self.search.screen

    def _judgements(self, stage: str, reading: Reading, claims: Iterable[Claim]) -> tuple[Judgement, ...]:
        config, phase, effort = self.config, _phase(stage), self._effort(stage)
        parameters = self._parameters(reading.learner)
        worlds = {
            name: changed_world(load_map(self.search.reference.maps[name]), drawing)
            for name, drawing in reading.drawings.items()
        }
        runs: list[Runs] = []
        for name, world in worlds.items():
            letters = config.environments[name].tasks
            for method in config.methods:
                lives = self._lives(phase, world, name, letters, method, parameters, effort.seeds)
                runs += runs_of(name, method, letters, lives)
        measures = config.measures
        measured = measure(runs, worlds, measures.window, measures.threshold_factor)
        whole = len(worlds) == len(config.environments)
        evidence = Evidence(
            per_seed=measured.per_seed,
            subgoals=measured.subgoals,
            steps=measured.steps,
            worlds=worlds,
            how=Resampling(config.statistics.confidence, effort.resamples),
            window=measures.window,
            breakpoint=config.growth.breakpoint,
            growth=self._growth(phase, worlds, parameters, effort.growth_runs) if whole else None,
            exact=True,
        )
        return tuple(claim.judge(evidence) for claim in claims if claim.id not in NOT_VARIED)

    def _parameters(self, learner: Changes) -> Parameters:
        values = {**self.search.reference.learner, **learner, "learning.max_steps": self.search.max_steps}
        given = {group: getattr(self.config, group).to_dict() for group in Parameters.__struct_fields__}
        return Parameters.from_dict(given).replace(**{name.replace(".", "__"): value for name, value in values.items()})

    def _lives(
        self, phase: str, world: GridWorld, name: str, letters: str, method: str, parameters: Parameters, seeds: int
    ) -> dict[str, np.ndarray]:
        unit = json.dumps([phase, name, world.text, method, read_by(method, parameters)])
        if unit not in self.learned:
            self.learned[unit] = learn_lives(
                world, letters, method, parameters, self.config.root_seed, range(seeds), STREAM, phase, name
            )
        return self.learned[unit]

    def _growth(self, phase: str, worlds: Mapping[str, GridWorld], parameters: Parameters, runs: int) -> np.ndarray:
        growth = self.config.growth
        world = worlds[growth.environment]
        unit = json.dumps([phase, "growth", world.text, read_by(GROWTH_METHOD, parameters)])
        if unit not in self.learned:
            self.learned[unit] = grow_lives(
                world, growth.environment, growth.tasks, parameters, self.config.root_seed, range(runs), STREAM, phase
            )
        return self.learned[unit]


def _phase(stage: str) -> str:
    """Return the name of a stage in random streams."""
    return "final" if stage.startswith("final") else "screen"


def read_by(method: str, parameters: Parameters) -> dict[str, Any]:
    """Return the values of the parameters that a method reads, by their full names."""
    return {
        f"{group}.{name}": value
        for group, values in parameters.to_dict().items()
        for name, value in values.items()
        if not f"{group}.{name}".startswith(IGNORED[method])
    }


# -- tables -------------------------------------------------------------------------------------------------------


def tried_frame(outcomes: Outcomes) -> pd.DataFrame:
    """Return a row for every reading tried in every stage; learner, drawings and verdicts are JSON."""
    rows = []
    for own in outcomes.tried:
        reproduced, failing = own.score()
        rows.append(
            {
                "stage": own.stage,
                "seeds": own.seeds,
                "learner": json.dumps(own.reading.learner),
                "drawings": json.dumps(own.reading.drawings),
                "changes": own.reading.changes,
                "claims": len(own.judgements),
                "reproduced": reproduced,
                "parts_failing": failing,
                "verdicts": json.dumps({judged.claim.id: str(judged.verdict) for judged in own.judgements}),
                "chosen_by": _chosen_by(own, outcomes),
            }
        )
    return pd.DataFrame(rows)


def _chosen_by(own: Judged, outcomes: Outcomes) -> str:
    named = [("all claims", outcomes.choice), *zip(("first half", "second half"), outcomes.by_half, strict=True)]
    return "; ".join(name for name, choice in named if choice is own)


def halves_frame(outcomes: Outcomes, halves: Sequence[Sequence[str]]) -> pd.DataFrame:
    """Return the score on one half of the claims of a choice made by the other.

    A row for each half: claims reproduced by the reference and by the reading chosen on that half, on the half itself
    (``chosen_on``) and on the other (``checked_on``), with the final seeds.
    """
    rows = []
    for place, (choice, chosen_on) in enumerate(zip(outcomes.by_half, halves, strict=True)):
        row: dict[str, Any] = {
            "half": ("first", "second")[place],
            "learner": json.dumps(choice.reading.learner),
            "drawings": json.dumps(choice.reading.drawings),
        }
        for name, claims in (("chosen_on", chosen_on), ("checked_on", halves[1 - place])):
            row[f"claims_{name}"] = len(claims)
            row[f"reference_{name}"] = outcomes.reference.score(claims)[0]
            row[f"choice_{name}"] = choice.score(claims)[0]
        rows.append(row)
    return pd.DataFrame(rows)


def parts_frame(outcomes: Outcomes) -> pd.DataFrame:
    """Return a row for each part of each claim in the final readings: the numbers behind the choice."""
    rows = [
        {
            "learner": json.dumps(own.reading.learner),
            "drawings": json.dumps(own.reading.drawings),
            "id": judged.claim.id,
            "part": part.text,
            "estimate": part.estimate.value,
            "low": part.estimate.low,
            "high": part.estimate.high,
            "unit": part.unit,
            "demand": part.demand,
            "outcome": str(part.outcome),
        }
        for own in outcomes.tried
        if own.stage == "final"
        for judged in own.judgements
        for part in judged.parts
    ]
    return pd.DataFrame(rows)


def main(search_file: Path = SEARCH, config_file: Path = CONFIG, folder: Path = REPORTS) -> None:
    """Search, and write tried.csv, parts.csv and halves.csv."""
    try:
        search = msgspec.convert(read_yaml(search_file), Search)
        outcomes = Searcher(search, completed(read_yaml(config_file))).run()
        folder.mkdir(parents=True, exist_ok=True)
        write_csv(tried_frame(outcomes), folder / "tried.csv")
        write_csv(parts_frame(outcomes), folder / "parts.csv")
        write_csv(halves_frame(outcomes, search.halves), folder / "halves.csv")
    except (UserError, msgspec.ValidationError) as error:
        sys.exit(f"error: {error}")


if __name__ == "__main__":
    main()
