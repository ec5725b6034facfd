"""The configuration: every key with its default, its range, where the default comes from and a sentence on it.

The classes below are the only definition. The checks of runs, studies and single jobs,
the defaults of jobs and ``config/README.md`` all follow from them. To add a key, add a field and use it.

A mark says where a default comes from: the text of the article (`STATED`), a cited work or a public re-implementation
of it (`FV`), or this reconstruction, because it is simple or usual (`CHOSEN`) or because it fits the article's claims
(`FITTED`); ``docs/reconstruction.md`` gives the reasons.
"""

from collections.abc import Collection, Mapping
from itertools import pairwise
from typing import Annotated, Literal, Self

import msgspec
from msgspec import Meta

from ptl.errors import UserError
from ptl.keys import ConfigurationError, Group, key, repeated, shortened, text

STATED, CHOSEN, FITTED = "stated", "chosen", "chosen, because it fits"
FV = "source (Fernandez and Veloso)"

RUN_NAME = text("[A-Za-z0-9][A-Za-z0-9_-]*", "letters, digits, _ and -, not starting with _ or -")
NAME = text("[a-z][a-z0-9_]*", "lower-case letters, digits and _, starting with a letter")
NAME_OR_NONE = text("([a-z][a-z0-9_]*)?", "the name of an environment")
# Snakemake takes braces for wildcards, and its report puts labels and parameters into script elements as they are.
TITLE = text(r"[^{}<\x00-\x1f\x7f]*", "text without braces, < and control characters", 200)
PATH = text(r"[^-{}<\x00-\x1f\x7f][^{}<\x00-\x1f\x7f]*", "a path without braces and <, not starting with -", 1000)
METHOD = {**PATH, "wanted": "a method: a built-in name, a file that ends in .py, or package.module:Class"}
COLOUR = text("(#[0-9a-fA-F]{6})?", "a colour such as #8a5a00")
TASKS = text("[A-HJ-Z]*", "capital letters other than I", 25)

Name = Annotated[str, key("", **NAME)]


# -- hyper-parameters of learning


class Learning(Group, frozen=True, kw_only=True):
    """Tabular Q-learning."""

    episodes: Annotated[int, key("Episodes of each task.", CHOSEN, ge=1, le=10**6)] = 200
    alpha: Annotated[float, key("Learning rate.", FV, gt=0, le=1)] = 0.05
    gamma: Annotated[float, key("Discount per step.", FV, gt=0, le=1)] = 0.95
    epsilon: Annotated[float, key("Probability of a uniformly random action.", CHOSEN, ge=0, le=1)] = 0.1
    ties: Annotated[
        Literal["random", "first"],
        key(
            "Which of equal greedy actions is taken: any of them at random, or the first in the order north, south,"
            " west, east.",
            CHOSEN,
        ),
    ] = "random"
    max_steps: Annotated[
        int, key("Steps after which an episode is truncated and counted as unsuccessful.", CHOSEN, ge=1, le=10**12)
    ] = 10**7


class Skills(Group, frozen=True, kw_only=True):
    """Selection and use of skills (PTL)."""

    prior_form: Annotated[
        Literal["exponential", "gaussian", "uniform"],
        key("Form of the prior over the distance between subgoal and goal.", CHOSEN),
    ] = "exponential"
    prior_width: Annotated[
        float, key("sigma, width of the prior as a share of the map's diagonal.", CHOSEN, gt=0, le=1000)
    ] = 0.1
    likelihood_exponent: Annotated[
        float, key("kappa, exponent of the performance in the likelihood.", CHOSEN, ge=0, le=100)
    ] = 2.0
    likelihood_weight: Annotated[
        float, key("beta, weight of the newest episode in the moving average of the performance.", CHOSEN, gt=0, le=1)
    ] = 0.5
    patience: Annotated[
        float,
        key("Steps of exploration before a skill is drawn again, in numbers of states.", CHOSEN, gt=0, le=10**6),
    ] = 1.0
    patience_growth: Annotated[
        float, key("Factor on the patience at every further draw in an episode.", CHOSEN, ge=1, le=1000)
    ] = 2.0
    skill_use: Annotated[
        Literal["reselect", "lead_in", "initiation_set", "mixing", "initial_values"],
        key(
            "What a drawn skill does: lead, with another draw when patience runs out; lead once; lead again in its"
            " initiation set as well; be mixed into the agent's own policy; or give Q the values that it starts from.",
            FITTED,
        ),
    ] = "initiation_set"
    null_skill: Annotated[
        bool, key('Whether "no guidance" stays a candidate once the library holds a skill.', CHOSEN)
    ] = True


class Subgoals(Group, frozen=True, kw_only=True):
    """Discovery of subgoals and update of the library."""

    trajectories: Annotated[
        int, key("T, successful episodes of a task that the FD metric looks at.", CHOSEN, ge=1, le=10**6)
    ] = 30
    distance_form: Annotated[
        Literal["tent", "parabola"],
        key("Form of the FD metric's distance along a path: 0 at both ends, 1 half-way.", CHOSEN),
    ] = "tent"
    known: Annotated[
        Literal["subgoals", "paths"],
        key("What the incremental metric takes as known: stored subgoals, or also the skills' paths to them.", CHOSEN),
    ] = "subgoals"
    cover_radius: Annotated[
        int, key("r, steps around what is known that count as known too.", CHOSEN, ge=0, le=10**6)
    ] = 2
    novelty: Annotated[
        float,
        key(
            "rho, least mean length of the unknown rests as a share of the visited part's diameter.", CHOSEN, ge=0, le=1
        ),
    ] = 0.2
    threshold: Annotated[float, key("theta, least incremental metric of a new subgoal.", CHOSEN, ge=0, le=1)] = 0.2


class PolicyReuse(Group, frozen=True, kw_only=True):
    """PRQ-learning."""

    psi: Annotated[float, key("Probability of following the past policy in the first step.", FV, ge=0, le=1)] = 1.0
    psi_decay: Annotated[float, key("upsilon, factor on that probability at every step.", FV, ge=0, lt=1)] = 0.95
    temperature: Annotated[float, key("tau of the first episode.", FV, ge=0, le=10**6)] = 0.0
    temperature_step: Annotated[float, key("Growth of tau after every episode.", FV, ge=0, le=10**6)] = 0.05
    untaught: Annotated[
        Literal["new_policy", "first_action"],
        key("What a past policy does where its values are all equal: give way, or take the first action.", CHOSEN),
    ] = "new_policy"


class FullTransfer(Group, frozen=True, kw_only=True):
    """Full transfer."""

    hands_over: Annotated[
        Literal["latest", "mean", "policy"],
        key(
            "What a task starts from: the last task's Q, the mean of the Q of all earlier tasks, or equal small values"
            " for the last task's greedy actions.",
            STATED,
        ),
    ] = "latest"


class Parameters(Group, frozen=True, kw_only=True):
    """All hyper-parameters of learning: what a method depends on."""

    learning: Learning = Learning()
    skills: Skills = Skills()
    subgoals: Subgoals = Subgoals()
    policy_reuse: PolicyReuse = PolicyReuse()
    full_transfer: FullTransfer = FullTransfer()

    @classmethod
    def from_json(cls, text: str) -> Self:
        """Build from JSON, as a job gets it on its command line."""
        try:
            given = msgspec.json.decode(text)
        except (msgspec.DecodeError, RecursionError) as error:
            raise UserError(
                f"parameters: {shortened(text)} is not JSON ({error});"
                """ give groups of the configuration such as {"learning": {"episodes": 300}}"""
            ) from None
        return cls.from_dict(given)


# -- the run


class ArticleItems(Group, frozen=True, kw_only=True, omit_defaults=True):
    """Numbers of the article's items that show an environment; other environments leave them out."""

    map: Annotated[Literal["figure05", "figure06", "figure07"] | None, key("Figure with the map.")] = None
    discovery: Annotated[
        Literal["figure09", "figure10", "figure11"] | None, key("Figure with the subgoal discovery metrics.")
    ] = None
    prior: Annotated[Literal["figure03"] | None, key("Given to the environment whose map shows the prior.")] = None
    measures: Annotated[
        Literal["figure13"] | None, key("Given to the environment whose curves show the measures of transfer.")
    ] = None


MapFormat = Literal["text", "moving_ai", "ros", "labmaze", "frozen_lake", "point_maze", "maze2d"]
"""Formats of map files, see `ptl.world.map_files`."""

Place = Annotated[list[Annotated[int, Meta(ge=1, le=10**9)]], Meta(min_length=2, max_length=2)]


class MapOptions(Group, frozen=True, kw_only=True, omit_defaults=True):
    """What the file of a map leaves open; the options of commands have the same names."""

    format: Annotated[MapFormat | None, key("Format of the file, if its content can be read in several ways.")] = None
    start: Annotated[
        Place | None,
        key("Row and column of the start, counted from 1.", wanted="a row and a column, counted from 1: [3, 4]"),
    ] = None
    goals: Annotated[
        list[Place],
        key(
            "Rows and columns of the goals A, B, ..., counted from 1.",
            wanted="up to 25 rows and columns, counted from 1: [[3, 4], [5, 6]]",
            max_length=25,
        ),
    ] = []  # noqa: RUF012 (msgspec copies it)
    seed: Annotated[
        Annotated[int, Meta(ge=0, le=2**63 - 1)] | None,
        key("Seed with which a start and goals are drawn that nothing else gives; 0 if left out."),
    ] = None
    cell: Annotated[
        float,
        key("Metres of a cell of a ROS map, a multiple of its resolution; a cell is a pixel if 0.", ge=0, le=10**6),
    ] = 0.0
    slip: Annotated[
        float,
        key(
            "Probability that a step goes in a direction drawn uniformly from the four instead of that of the action;"
            " methods are not told of it.",
            CHOSEN,
            ge=0,
            le=1,
        ),
    ] = 0.0


class Environment(Group, frozen=True, kw_only=True):
    """A map and its tasks."""

    map: Annotated[str, key("File of the map, relative to the folder in which the workflow runs.", **PATH)]
    map_options: MapOptions = MapOptions()
    title: Annotated[str, key("Name in captions and figures; the environment's own name if empty.", **TITLE)] = ""
    tasks: Annotated[
        str,
        key(
            "Goal letters in the order in which they are learned, alphabetical for the article's environments;"
            " all goals of the map in alphabetical order if empty.",
            STATED,
            **TASKS,
        ),
    ] = ""
    discovery_tasks: Annotated[
        str, key("Tasks that the figure of subgoal discovery shows; the last three if empty.", **TASKS)
    ] = ""
    article_items: ArticleItems = ArticleItems()


class ForeignResults(Group, frozen=True, kw_only=True):
    """Results of a method that another program has run, by the method's name."""

    file: Annotated[
        str,
        key("CSV table with the columns environment, method, task, seed, episode, steps: docs/gymnasium.md.", **PATH),
    ]
    label: Annotated[str, key("Name in tables and figures; made from the method's name if empty.", **TITLE)] = ""
    colour: Annotated[str, key("Colour in tables and figures; one that no method has if empty.", **COLOUR)] = ""


class Measures(Group, frozen=True, kw_only=True):
    """Measures of transfer."""

    window: Annotated[
        int,
        key(
            "Episodes whose mean is the asymptotic performance and is compared with the threshold.",
            CHOSEN,
            ge=1,
            le=10**6,
        ),
    ] = 10
    threshold_factor: Annotated[
        float,
        key(
            "The threshold as a multiple of the shortest path, or of the least expected steps where steps slip.",
            CHOSEN,
            ge=1,
            le=10**6,
        ),
    ] = 1.5


class Statistics(Group, frozen=True, kw_only=True):
    """Uncertainty."""

    confidence: Annotated[float, key("Confidence level of every interval.", gt=0, lt=1)] = 0.95
    resamples: Annotated[int, key("Bootstrap resamples.", ge=100, le=10**6)] = 2000


class Decision(Group, frozen=True, kw_only=True):
    """Runs that decide the claims, beside those of the tables, as many as a verdict needs."""

    looks: Annotated[
        tuple[Annotated[int, Meta(ge=1, le=10**5)], ...],
        key(
            "Runs per environment and method, and lives of the growing library, at each look at the claims; where no"
            " claim is open any more, none are added.",
            CHOSEN,
            wanted="a list of increasing whole numbers",
            min_length=1,
        ),
    ] = (100, 200, 400, 800, 1600, 3200)

    def __post_init__(self) -> None:
        super().__post_init__()
        if any(after <= before for before, after in pairwise(self.looks)):
            raise ConfigurationError.of_value("looks", list(self.looks), "a list of increasing whole numbers")


class Growth(Group, frozen=True, kw_only=True):
    """Growth of the skill library."""

    environment: Annotated[str, key("Environment whose map is used; the last one if empty.", **NAME_OR_NONE)] = ""
    tasks: Annotated[int, key("Tasks with random start and goal in one life.", STATED, ge=2, le=10**5)] = 30
    runs: Annotated[int, key("Lives, each with a fresh library; 0 for none.", STATED, ge=0, le=10**5)] = 30
    breakpoint: Annotated[int, key("Number of tasks after which growth slows down.", STATED, ge=1, le=10**5)] = 7


class SubgoalFrequencies(Group, frozen=True, kw_only=True):
    """Subgoals over all pairs of start and goal."""

    trajectories: Annotated[int, key("Successful episodes of each pair's task.", CHOSEN, ge=1, le=10**6)] = 30
    starts: Annotated[
        Literal["all"] | Annotated[int, Meta(ge=0, le=10**6)],
        key("All start states, or the size of a random sample of them (for a quick look only); 0 for no survey."),
    ] = "all"
    batches: Annotated[
        int,
        key("Jobs that an environment's goals are shared out to; the counts do not depend on it.", ge=1, le=1000),
    ] = 8


class Configuration(Parameters, frozen=True, kw_only=True):
    """The configuration of a run."""

    run: Annotated[
        str, key("Name of the run; results go to results/<run>/ and products to reports/<run>/.", **RUN_NAME)
    ]
    root_seed: Annotated[int, key("Seed from which every random stream of the run derives.", ge=0, le=2**63 - 1)] = 2019
    seeds: Annotated[int, key("Learning runs per environment and method.", STATED, ge=1, le=10**5)] = 30
    methods: Annotated[
        list[Annotated[str, key("", **METHOD)]],
        key(
            "Methods to compare: names of built-in ones, files that end in .py, or package.module:Class.",
            wanted="a list of one or more methods (a built-in name, a file ending in .py, package.module:Class),"
            " each once",
            min_length=1,
        ),
    ]
    method_parameters: Annotated[
        dict[Name, dict[str, bool | int | float | str]],
        key(
            "Parameters that single methods declare for themselves, by method and parameter.",
            wanted="names of methods, each with its parameters",
        ),
    ] = {}  # noqa: RUF012 (msgspec copies it)
    environments: Annotated[
        dict[Name, Environment],
        key(
            "Environments by name, in the order in which tables and figures show them.",
            wanted="one or more names, each with its keys",
            min_length=1,
        ),
    ]
    foreign_results: Annotated[
        dict[Name, ForeignResults],
        key("Methods that other programs have run, beside those of this package.", wanted="names, each with its keys"),
    ] = {}  # noqa: RUF012 (msgspec copies it)
    measures: Measures = Measures()
    statistics: Statistics = Statistics()
    decision: Decision = Decision()
    growth: Growth = Growth()
    subgoal_frequencies: SubgoalFrequencies = SubgoalFrequencies()

    @property
    def article(self) -> bool:
        """Whether the run learns maps of the article, so that its claims, numbers and experiments are about the run."""
        return of_article(self.environments)

    def __post_init__(self) -> None:
        super().__post_init__()
        if twice := repeated(self.methods):
            raise ConfigurationError("methods", f"{twice[0]} is repeated; name a method once")
        if self.measures.window > self.learning.episodes:
            raise ConfigurationError(
                "measures.window",
                f"{self.measures.window} must not exceed learning.episodes ({self.learning.episodes})",
            )
        if self.growth.tasks <= self.growth.breakpoint:
            raise ConfigurationError(
                "growth.tasks", f"{self.growth.tasks} must exceed growth.breakpoint ({self.growth.breakpoint})"
            )
        if self.growth.environment and self.growth.environment not in self.environments:
            raise ConfigurationError.of_value(
                "growth.environment", self.growth.environment, f"one of {', '.join(self.environments)}"
            )
        if self.article and not (self.growth.runs and self.subgoal_frequencies.starts):
            empty = "subgoal_frequencies.starts" if self.growth.runs else "growth.runs"
            raise ConfigurationError(empty, "0 is not allowed with a map of the article, whose claims need it")
        _check_article_items(self.environments)


def of_article(environments: Mapping[str, Environment]) -> bool:
    """Return whether a map of the article is among the environments."""
    return any(environment.article_items.to_dict() for environment in environments.values())


def _check_article_items(environments: Mapping[str, Environment]) -> None:
    shown: dict[str, str] = {}
    for name, environment in environments.items():
        for kind, item in environment.article_items.to_dict().items():
            key = f"environments.{name}.article_items.{kind}"
            if item in shown:
                raise ConfigurationError(key, f"{item} is already {shown[item]}; give an item to one environment")
            shown[item] = key


def check_tasks(tasks: str, goals: Collection[str], key: str = "tasks") -> None:
    """Refuse tasks that are not goals of a map, that are repeated, or none at all.

    Parameters
    ----------
    tasks : str
        Goal letters in the order in which they are learned.
    goals : collection of str
        Goal letters of the map.
    key : str
        Name of the key in the message.
    """
    wanted = f"one or more of {''.join(goals)}, each once"
    if not tasks or repeated(tasks) or set(tasks) - set(goals):
        raise ConfigurationError.of_value(key, tasks, wanted)
