"""The cost of a run, estimated from its configuration and maps before anything is planned or learned.

Rules of thumb, fitted to runs on the published maps, within a factor of about three: they prevent
accidental runs of several weeks, or of more jobs than can be planned in memory.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from ptl.config import Configuration, Learning
from ptl.errors import UserError
from ptl.text import number
from ptl.world.gridworld import GridWorld

START = 0.1
"""CPU seconds of a job besides learning."""

LIFE = 0.01
"""CPU seconds of a life besides its steps: subgoals and skills."""

STEPS_A_SECOND = 2e8
SEARCH = 20
"""Steps until a task is learned from nothing, in numbers of states times the length of the shortest path."""

COSTLY = {"full_transfer": 10}
"""Methods that take many times the steps of learning from nothing, where the old policy leads astray."""

SURVEY = 2e-9
"""CPU seconds of the survey, for each trajectory and state cubed."""

MIN_BYTES, PLANNED_BYTES = 3e8, 20_000
"""Memory of the packages themselves, and of Snakemake's graph for each job."""

MAX_JOBS, MAX_HOURS, MAX_BYTES = 40_000, 500, 8 * 10**9
"""Above one of these limits a run must be requested: planning takes 1 GB; CPU hours; memory of one process."""

FLAG = "PTL_LARGE_RUN"
"""Environment variable that requests it."""


@dataclass(frozen=True)
class Cost:
    """Approximate cost of a run.

    Attributes
    ----------
    jobs : int
        Jobs that learn; those that measure and draw are few.
    steps : float
        Steps of all lives.
    hours : float
        CPU hours.
    memory : float
        Bytes that planning or measuring takes, whichever takes more.
    """

    jobs: int
    steps: float
    hours: float
    memory: float

    def __str__(self) -> str:
        return (
            f"{number(self.jobs)} learning jobs, {number(self.steps / 1e6)} million steps, {self.time},"
            f" {self.memory / 1e9:.1f} GB of memory"
        )

    @property
    def time(self) -> str:
        """CPU time as readers see it: minutes up to two hours."""
        minutes = max(round(60 * self.hours), 1)
        return f"{number(minutes)} CPU minute{'s' * (minutes > 1)}" if minutes <= 120 else f"{self.hours:.1f} CPU hours"


def cost_of(run: Configuration, worlds: Mapping[str, GridWorld]) -> Cost:
    """Estimate the total cost of all jobs of a completed configuration, at least one look at the claims included.

    Parameters
    ----------
    worlds : mapping
        Map of each environment.
    """
    episodes, survey = run.learning.episodes, run.subgoal_frequencies
    seeds = dict.fromkeys(run.methods, run.seeds)
    deciding = {}
    if run.article:
        deciding = dict.fromkeys(run.methods, run.decision.looks[0])
    steps, lives, tasks, surveyed = 0.0, 0, 0, 0.0
    for name, entry in run.environments.items():
        world = worlds[name]
        life = steps_of_life(world, entry.tasks, run.learning)
        tasks += len(entry.tasks)
        for method, own in seeds.items():
            lives += own + deciding.get(method, 0)
            steps += life * (own + deciding.get(method, 0)) * COSTLY.get(method, 1)
        starts = world.n_states if survey.starts == "all" else min(survey.starts, world.n_states)
        surveyed += SURVEY * survey.trajectories * starts * world.n_states**2
    world = worlds[run.growth.environment]
    grown = run.growth.runs + (run.decision.looks[0] if run.article else 0)
    steps += grown * run.growth.tasks * steps_of_task(world.n_states, world.diagonal, run.learning)
    learning = len(run.environments) * sum(seeds.values())
    jobs = learning + run.growth.runs + len(run.environments) * survey.batches * bool(survey.starts)
    return Cost(
        jobs=jobs,
        steps=steps,
        hours=_hours(jobs, lives + grown, steps) + surveyed / 3600,
        memory=MIN_BYTES + max(PLANNED_BYTES * jobs, 8 * sum(seeds.values()) * tasks * episodes),
    )


def together(jobs: int, lives: int, steps: float) -> Cost:
    """Return the cost of jobs with these numbers of lives and steps."""
    return Cost(jobs, steps, _hours(jobs, lives, steps), MIN_BYTES + PLANNED_BYTES * jobs)


def _hours(jobs: int, lives: int, steps: float) -> float:
    return (START * jobs + LIFE * lives + steps / STEPS_A_SECOND) / 3600


def steps_of_life(world: GridWorld, tasks: str, learning: Learning) -> float:
    """Return the approximate steps of a life of tasks without transfer."""
    lengths = [world.shortest_path_length(world.start, world.goals[task]) for task in tasks]
    return sum(steps_of_task(world.n_states, length, learning) for length in lengths)


def steps_of_task(states: int, distance: float, learning: Learning) -> float:
    """Return the approximate steps of a task: the search for the goal, then episodes along the path."""
    walk = states * distance
    along = min(walk, distance / (1 - learning.epsilon)) if learning.epsilon < 1 else walk
    return min(SEARCH * walk + learning.episodes * along, float(learning.episodes * learning.max_steps))


def check_cost(cost: Cost, allowed: bool) -> None:
    """Refuse a run that is probably larger than intended, unless it was requested.

    Raises
    ------
    UserError
        Naming the estimate, the limit and the ways on.
    """
    for amount, limit, unit in (
        (cost.jobs, MAX_JOBS, "learning jobs"),
        (cost.hours, MAX_HOURS, "CPU hours"),
        (cost.memory, MAX_BYTES, "bytes of memory"),
    ):
        if amount > limit and not allowed:
            raise UserError(
                f"this run would take {cost} (estimated), more than {number(limit)} {unit}; split it into"
                f" configurations with fewer seeds, each with its own 'run' and 'root_seed', or set"
                f" {FLAG}=1 to run it as it is"
            )
