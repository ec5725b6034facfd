"""The search for drawings and settings that fit the article's claims, over the values of config/fit.yaml.

A *learner* is a setting that all environments share, a *drawing* a map of one environment. Environments do not depend
on each other, so the best drawing of each is found on its own claims:

1. every drawing with the first few learners (the probes), of which the best few drawings go on;
2. every learner with these drawings; for each learner the best drawing of each environment;
3. every learner with its drawings on all claims: the *screen*. The best ones, the reference, and the best by either
   half of the claims are the finalists;
4. the finalists' learners with these drawings again, with other random numbers and more seeds, and for each the best
   drawing of each environment. The best finalist is the choice.

What a method does not read cannot change it, so lives are learned once for all settings that agree on what it reads,
and kept in files: an interrupted search goes on where it stopped.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import pandas as pd

from ptl.claims import CLAIMS
from ptl.claims.claim import Claim, Judgement
from ptl.claims.evidence import Evidence
from ptl.claims.verdict import Outcome, Verdict
from ptl.config import Configuration, Parameters
from ptl.errors import UserError
from ptl.files.arrays import read_arrays, write_arrays
from ptl.files.configuration import read_yaml
from ptl.files.provenance import code_digest
from ptl.files.schema import FIT
from ptl.keys import ConfigurationError, Group, key
from ptl.learning.growth import METHOD as GROWTH_METHOD
from ptl.learning.lives import grow_lives, learn_lives, runs_of
from ptl.measures.measures import Runs, measure
from ptl.measures.statistics import Resampling
from ptl.world.drawing import changed_world
from ptl.world.gridworld import GridWorld, load_map
from studies.robustness.verdicts import NOT_VARIED

STREAM = "fit"
"""First name of every random stream of the search; settings share their random numbers, stages do not."""

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


# -- the file of the search


class Effort(Group, frozen=True, kw_only=True):
    """Effort of a stage."""

    seeds: Annotated[int, key("Learning runs per environment and method.", ge=10, le=10**5)]
    growth_runs: Annotated[int, key("Lives of the growing library.", ge=10, le=10**5)]
    resamples: Annotated[int, key("Bootstrap resamples.", ge=100, le=10**6)]


class First(Group, frozen=True, kw_only=True):
    """The setting from which changes are counted: map files, and every key that a learner may change."""

    maps: dict[str, str]
    learner: dict[str, Any]


class Search(Group, frozen=True, kw_only=True):
    """Everything that config/fit.yaml fixes before the search."""

    screen: Effort
    final: Effort
    probes: Annotated[int, key("Learners that see every drawing.", ge=1, le=100)]
    kept: Annotated[int, key("Drawings that go on, beside the reference's.", ge=1, le=100)]
    finalists: Annotated[int, key("Learners that are decided.", ge=1, le=100)]
    max_steps: Annotated[int, key("Steps after which an episode is truncated.", ge=1, le=10**12)]
    reference: First
    drawings: dict[str, list[dict[str, Any]]]
    learners: list[dict[str, Any]]
    halves: Annotated[list[list[str]], key("Claims of either half.", min_length=2, max_length=2)]

    def __post_init__(self) -> None:
        super().__post_init__()
        for changes in self.learners:
            for name in changes:
                if name not in self.reference.learner:
                    raise ConfigurationError(
                        f"learners.{name}", "is not in reference.learner; give its first value there"
                    )
        named = [claim for half in self.halves for claim in half]
        varied = {claim.id for claim in CLAIMS} - set(NOT_VARIED)
        if sorted(named) != sorted(varied):
            odd = sorted(varied.symmetric_difference(named)) or ["a claim is there twice"]
            raise ConfigurationError("halves", f"must name each claim that a setting can change once ({odd[0]})")


def read_search(path: str | Path) -> Search:
    """Read and check config/fit.yaml; raises UserError with one line that names the file and the key."""
    try:
        return Search.from_dict(read_yaml(path))
    except ConfigurationError as error:
        raise UserError(f"{path}: {error}") from error


# -- settings and scores


@dataclass(frozen=True)
class Setting:
    """A learner and the drawings of all environments or of some of them, as changes against the reference."""

    learner: Changes
    drawings: Mapping[str, Changes]

    @property
    def changes(self) -> int:
        """Number of values that differ from the reference: the less, the simpler."""
        return len(self.learner) + sum(bool(drawing) for drawing in self.drawings.values())


@dataclass(frozen=True)
class Score:
    """What the rule compares, best first: claims reproduced, failing parts, changes."""

    reproduced: int
    failing: int
    changes: int

    @property
    def rank(self) -> tuple[int, int, int]:
        """Smaller is better."""
        return -self.reproduced, self.failing, self.changes


def score(judgements: Iterable[Judgement], setting: Setting) -> Score:
    """Return the score of a setting on some claims."""
    judged = list(judgements)
    return Score(
        sum(own.verdict is Verdict.REPRODUCED for own in judged),
        sum(part.outcome is Outcome.FAILS for own in judged for part in own.parts),
        setting.changes,
    )


def claims_of(environment: str, claims: Iterable[Claim] = CLAIMS) -> list[Claim]:
    """Return the claims on one environment alone (``E1-...`` is on env1); the others need several."""
    return [claim for claim in claims if claim.id.startswith(f"E{environment.removeprefix('env')}-")]


@dataclass(frozen=True)
class Judged:
    """A setting with the verdicts of a stage."""

    stage: str
    setting: Setting
    seeds: int
    judgements: tuple[Judgement, ...]

    def score(self, claims: Iterable[str] | None = None) -> Score:
        """Return the score on all claims judged, or on those named."""
        wanted = None if claims is None else set(claims)
        return score((own for own in self.judgements if wanted is None or own.claim.id in wanted), self.setting)


def best(settings: Sequence[Judged], claims: Iterable[str] | None = None) -> Judged:
    """Return the best setting by the rule, on all claims judged or on those named; the earlier of equals."""
    named = None if claims is None else list(claims)
    return min(settings, key=lambda own: own.score(named).rank)


# -- the search


@dataclass(frozen=True)
class Outcomes:
    """All that was tried, in order, and the choices: by all claims, and by either half."""

    tried: list[Judged]
    choice: Judged
    by_half: list[Judged]
    reference: Judged


class Searcher:
    """Runs the search of `Search` on top of a configuration.

    Parameters
    ----------
    search : Search
    config : Configuration
        The run, which gives all that the search does not vary.
    folder : path
        Where lives are kept.
    say : function
        Called with a line after each setting.
    """

    def __init__(
        self, search: Search, config: Configuration, folder: str | Path, say: Callable[[str], None] = lambda line: None
    ) -> None:
        self.search, self.config, self.folder, self.say = search, config, Path(folder), say
        self.tried: list[Judged] = []

    def run(self) -> Outcomes:
        """Go through all stages."""
        search = self.search
        learners: list[Changes] = [{}, *search.learners]
        kept = {name: self._kept_drawings(name, learners[: search.probes]) for name in self.config.environments}
        screened = [self._screened(learner, kept) for learner in learners]
        ranked = sorted(screened, key=lambda own: own.score().rank)
        by_half = [
            best([self._screened(learner, kept, half) for learner in learners], half).setting.learner
            for half in search.halves
        ]
        reference = Setting({}, {name: {} for name in self.config.environments})
        finals = [
            self._judge("final", reference, search.final, CLAIMS),
            *(self._decided(own.setting.learner, kept) for own in ranked[: search.finalists]),
        ]
        halves = [self._decided(learner, kept, half) for learner, half in zip(by_half, search.halves, strict=True)]
        return Outcomes(self.tried, best([*finals, *halves]), halves, finals[0])

    def _kept_drawings(self, environment: str, probes: Sequence[Changes]) -> list[Changes]:
        drawings = [{}, *self.search.drawings.get(environment, [])]
        ranks = {}
        for place, drawing in enumerate(drawings):
            seen = [self._own(learner, environment, drawing, "probe") for learner in probes]
            ranks[place] = best(seen).score().rank
        others = sorted(range(1, len(drawings)), key=ranks.__getitem__)
        return [drawings[place] for place in (0, *others[: self.search.kept])]

    def _own(self, learner: Changes, environment: str, drawing: Changes, stage: str) -> Judged:
        """Judge the claims on one environment alone."""
        setting = Setting(learner, {environment: drawing})
        effort = self.search.final if self._phase(stage) == "final" else self.search.screen
        return self._judge(stage, setting, effort, claims_of(environment))

    def _best_drawings(
        self, learner: Changes, kept: Mapping[str, list[Changes]], claims: Iterable[str] | None
    ) -> Setting:
        named = None if claims is None else list(claims)
        return Setting(
            learner,
            {
                name: best(
                    [self._own(learner, name, drawing, "drawings") for drawing in drawings], named
                ).setting.drawings[name]
                for name, drawings in kept.items()
            },
        )

    def _screened(
        self, learner: Changes, kept: Mapping[str, list[Changes]], claims: Iterable[str] | None = None
    ) -> Judged:
        setting = self._best_drawings(learner, kept, claims)
        return self._judge("screen", setting, self.search.screen, CLAIMS)

    def _decided(
        self, learner: Changes, kept: Mapping[str, list[Changes]], claims: Sequence[str] | None = None
    ) -> Judged:
        """Decide between the drawings of each environment, then judge the learner with those chosen."""
        chosen = {}
        for name, drawings in kept.items():
            decided = [self._own(learner, name, drawing, "final drawings") for drawing in drawings]
            chosen[name] = best(decided, claims).setting.drawings[name]
        return self._judge("final", Setting(learner, chosen), self.search.final, CLAIMS)

    # -- judging ---------------------------------------------------------------------------------------------

    def _judge(self, stage: str, setting: Setting, effort: Effort, claims: Iterable[Claim]) -> Judged:
        done = next((own for own in self.tried if (own.stage, own.setting) == (stage, setting)), None)
        if done is None:
            same = next(
                (own for own in self.tried if own.setting == setting and self._phase(own.stage) == self._phase(stage)),
                None,
            )
            judgements = same.judgements if same else self._judgements(stage, setting, effort, claims)
            done = Judged(stage, setting, effort.seeds, judgements)
            self.tried.append(done)
            own = done.score()
            self.say(
                f"{stage} {json.dumps(setting.learner)} {json.dumps(setting.drawings)}: {own.reproduced}, {own.failing}"
            )
        return done

    def _judgements(
        self, stage: str, setting: Setting, effort: Effort, claims: Iterable[Claim]
    ) -> tuple[Judgement, ...]:
        parameters = self._parameters(setting.learner)
        worlds = {name: self._world(name, drawing) for name, drawing in setting.drawings.items()}
        runs: list[Runs] = []
        for name, world in worlds.items():
            for method in self.config.methods:
                letters = self.config.environments[name].tasks
                runs += runs_of(
                    name, method, letters, self._lives(stage, world, name, letters, method, parameters, effort)
                )
        measures = self.config.measures
        measured = measure(runs, worlds, measures.window, measures.threshold_factor)
        whole = len(worlds) == len(self.config.environments)
        evidence = Evidence(
            per_seed=measured.per_seed,
            subgoals=measured.subgoals,
            steps=measured.steps,
            worlds=worlds,
            how=Resampling(self.config.statistics.confidence, effort.resamples),
            window=measures.window,
            breakpoint=self.config.growth.breakpoint,
            growth=self._growth(stage, worlds, parameters, effort) if whole else None,
            exact=True,
        )
        return tuple(claim.judge(evidence) for claim in claims if claim.id not in NOT_VARIED)

    def _parameters(self, learner: Changes) -> Parameters:
        values = {**self.search.reference.learner, **learner, "learning.max_steps": self.search.max_steps}
        given = {group: getattr(self.config, group).to_dict() for group in Parameters.__struct_fields__}
        return Parameters.from_dict(given).replace(**{name.replace(".", "__"): value for name, value in values.items()})

    def _world(self, environment: str, drawing: Changes) -> GridWorld:
        return changed_world(load_map(self.search.reference.maps[environment]), drawing)

    def _lives(
        self, stage: str, world: GridWorld, environment: str, letters: str, method: str, parameters: Parameters,
        effort: Effort,
    ) -> dict[str, np.ndarray]:  # fmt: skip
        stream = (STREAM, self._phase(stage), environment)
        unit = {
            "map": world.text, "tasks": letters, "method": method, "parameters": read_by(method, parameters),
            "seeds": effort.seeds, "stream": stream,
        }  # fmt: skip
        return self._kept(
            unit,
            lambda: learn_lives(
                world, letters, method, parameters, self.config.root_seed, range(effort.seeds), *stream
            ),
        )

    def _growth(
        self, stage: str, worlds: Mapping[str, GridWorld], parameters: Parameters, effort: Effort
    ) -> np.ndarray:
        growth = self.config.growth
        world = worlds[growth.environment]
        start = world.cells[world.start].tolist()  # of no effect, but part of the map
        stream = (STREAM, self._phase(stage))
        unit = {
            "map": world.text.replace("I", "."), "tasks": growth.tasks, "method": "growth",
            "parameters": read_by(GROWTH_METHOD, parameters), "runs": effort.growth_runs,
            "stream": stream, "start": start,
        }  # fmt: skip
        lives = self._kept(
            unit,
            lambda: {
                "library_size": grow_lives(
                    world, growth.environment, growth.tasks, parameters, self.config.root_seed,
                    range(effort.growth_runs), *stream,
                )
            },
        )  # fmt: skip
        return lives["library_size"]

    @staticmethod
    def _phase(stage: str) -> str:
        return "final" if stage.startswith("final") else "screen"

    def _kept(self, unit: Mapping[str, Any], learn: Callable[[], dict[str, np.ndarray]]) -> dict[str, np.ndarray]:
        modules = (
            "ptl.learning.lives",
            *[f"ptl.methods.{method}" for method in (unit["method"],) if method != "growth"],
        )
        whole = {**unit, "root_seed": self.config.root_seed, "code": code_digest(*modules)}
        name = hashlib.sha256(json.dumps(whole, sort_keys=True).encode()).hexdigest()[:32]
        path = self.folder / f"{name}.h5"
        group = "growth" if unit["method"] == "growth" else "lives"
        if not path.is_file():
            arrays = {f"{group}/{array}": values for array, values in learn().items()}
            write_arrays(path, FIT, arrays, {"unit": whole, "setting": name})
        arrays, origin = read_arrays(path, FIT)
        if origin["unit"] != json.loads(json.dumps(whole)) or {array.partition("/")[0] for array in arrays} != {group}:
            raise UserError(f"{path}: holds other lives than its name says; remove it and start the fit again")
        return {array.partition("/")[2]: values for array, values in arrays.items()}


def read_by(method: str, parameters: Parameters) -> dict[str, Any]:
    """Return the values of the parameters that a method reads, by their full names."""
    ignored = IGNORED.get(method, ())
    return {
        f"{group}.{name}": value
        for group, values in parameters.to_dict().items()
        for name, value in values.items()
        if not f"{group}.{name}".startswith(ignored)
    }


# -- tables


TRIED_COLUMNS = (
    "stage", "seeds", "learner", "drawings", "changes", "claims", "reproduced", "parts_failing", "verdicts",
    "chosen_by",
)  # fmt: skip


def tried_frame(outcomes: Outcomes) -> pd.DataFrame:
    """Return a row for every setting tried in every stage, columns `TRIED_COLUMNS`; settings and verdicts are JSON."""
    rows = []
    for own in outcomes.tried:
        got = own.score()
        rows.append(
            (
                own.stage, own.seeds, json.dumps(own.setting.learner), json.dumps(own.setting.drawings),
                own.setting.changes, len(own.judgements), got.reproduced, got.failing,
                json.dumps({judged.claim.id: str(judged.verdict) for judged in own.judgements}),
                _chosen_by(own, outcomes),
            )
        )  # fmt: skip
    return pd.DataFrame(rows, columns=list(TRIED_COLUMNS))


def _chosen_by(own: Judged, outcomes: Outcomes) -> str:
    named = [("all claims", outcomes.choice), *zip(("first half", "second half"), outcomes.by_half, strict=True)]
    return "; ".join(name for name, choice in named if choice is own)


def halves_frame(outcomes: Outcomes, halves: Sequence[Sequence[str]]) -> pd.DataFrame:
    """Return what a choice by one half of the claims is worth on the other.

    A row for each half: claims reproduced by the reference and by the setting chosen on that half, on the half itself
    (``chosen_on``) and on the other (``checked_on``), with the final seeds.
    """
    rows = []
    for place, (choice, chosen_on) in enumerate(zip(outcomes.by_half, halves, strict=True)):
        checked_on = halves[1 - place]
        rows.append(
            {
                "half": ("first", "second")[place],
                "learner": json.dumps(choice.setting.learner),
                "drawings": json.dumps(choice.setting.drawings),
                "claims_chosen_on": len(chosen_on),
                "reference_chosen_on": outcomes.reference.score(chosen_on).reproduced,
                "choice_chosen_on": choice.score(chosen_on).reproduced,
                "claims_checked_on": len(checked_on),
                "reference_checked_on": outcomes.reference.score(checked_on).reproduced,
                "choice_checked_on": choice.score(checked_on).reproduced,
            }
        )
    return pd.DataFrame(rows)


def parts_frame(outcomes: Outcomes) -> pd.DataFrame:
    """Return a row for each part of each claim in the final settings: the numbers behind the choice."""
    rows = [
        {
            "learner": json.dumps(own.setting.learner), "drawings": json.dumps(own.setting.drawings),
            "id": judged.claim.id, "part": part.text, "estimate": part.estimate.value, "low": part.estimate.low,
            "high": part.estimate.high, "unit": part.unit, "demand": part.demand, "outcome": str(part.outcome),
        }
        for own in outcomes.tried
        if own.stage == "final"
        for judged in own.judgements
        for part in judged.parts
    ]  # fmt: skip
    return pd.DataFrame(rows)
