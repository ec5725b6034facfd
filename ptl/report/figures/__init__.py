"""The figures of the report: a row of `figures` for each, and a module that draws it.

A module has a function that turns files or arrays into a tidy data frame, one that draws such a frame, and ``make``,
which does both for a job of the workflow. A module imports only what it draws with, so that editing one figure redraws
that figure and no other. To add a figure, write its module and add its row.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from ptl.measures.sample_size import note
from ptl.text import percent

ON_PAGE = ("curves", "measures", "discovery", "maps")
"""Modules whose figures come first on the page, in this order; the others follow."""

NO_CURVE = {"ptl_supervised", "ptl_unknown_goal"}
"""Methods that the article's learning curves leave out; they would hide the others."""

ARTICLE_NUMBERS = {
    "clusters": "figure01",
    "algorithms": "figure02",
    "prior": "figure03",
    "misleading_prior": "figure04",
    "frequencies": "figure08",
    "curves": "figure12",
    "measures": "figure13",
    "growth": "figure14",
}
"""Names of figures that do not belong to one environment, in a run on the article's maps."""

ARTICLE_ONLY = {"clusters", "algorithms", "misleading_prior"}
"""Figures that are about the article, not about the environments of a run."""

GREEDY = (
    " Policy reuse follows its own policy greedily, while the other methods keep acting at random now and then; so the"
    " ends of its curves are not to be compared with theirs."
)
"""What a caption says of curves with policy reuse."""

OUR_MAPS = {"config/environments/env1.txt", "config/environments/env2.txt"}
OUR_DRAWING = (
    " This drawing is ours, made from the article's words before anything was compared; the article's is lost."
)
"""Maps that this reconstruction drew, and what their captions say."""

ALWAYS_SHOWN = {"no_transfer", "ptl"}
"""Methods that some figures require."""


CLUSTER_LIVES = 30
"""Lives behind the figure of two clusters."""


@dataclass(frozen=True)
class Figure:
    """A figure of the report, as the workflow knows it.

    Attributes
    ----------
    module : str
        Module of this package with the function ``make(job)``.
    shows : str
        Label in the report.
    caption : str
        Explanation for the reader (plain text).
    needs : tuple of str
        Kinds of input files, by their names in `SOURCES` of ``workflow/rules/figures.smk``.
    groups : tuple of str
        Groups of the configuration that it depends on.
    environments : tuple of str
        Environments that it shows.
    methods : tuple of str
        Methods that it shows, in the order of the legend.
    with_foreign : bool
        Whether it shows the methods of other programs too.
    category : str
        Section of the report.
    item : str
        Name in the report of a figure without a number.
    on_top : bool
        Whether it opens the first page instead of standing among the figures.
    """

    module: str
    shows: str
    caption: str
    needs: tuple[str, ...]
    groups: tuple[str, ...] = ()
    environments: tuple[str, ...] = ()
    methods: tuple[str, ...] = ()
    with_foreign: bool = False
    category: str = "Figures"
    item: str = ""
    on_top: bool = False


def figures(config: Mapping[str, Any], article: bool) -> dict[str, Figure]:
    """Return the figures of a run by name, in the order of the report.

    Parameters
    ----------
    config : mapping
        The complete configuration; a figure that needs a method which is not compared is left out.
    article : bool
        Whether maps of the article are run: then the figures have its numbers, and those on the article and its
        sources are drawn too.
    """
    entries, compared = config["environments"], set(config["methods"])
    names, every_method = tuple(entries), tuple(config["methods"])
    curves = (tuple(name for name in every_method if name not in NO_CURVE) if article else ()) or every_method
    seeds, survey, growth = config["seeds"], config["subgoal_frequencies"], config["growth"]
    origin = (
        "The article states a heuristic on similarity with the goal; its form and width are our choice."
        if article
        else "Its form and width are those of the configuration."
    )
    off = {kind for kind, number in (("frequencies", survey["starts"]), ("growth", growth["runs"])) if not number}
    level = f"{percent(config['statistics']['confidence'])} bootstrap interval"

    later = [entry["tasks"][1:] for entry in entries.values()]
    strip = (
        " Below, the article's claims by how far they hold over all readings of their words; the page of the claims"
        " defines the classes."
    )
    front: dict[str, Any] = {
        "shows": "steps of every task relative to no transfer",
        "caption": (
            "Total steps of each method relative to those without transfer (ratio of the means over"
            f" {seeds} seeds{note(seeds, level)}, log scale): below 1 a method saves steps. The runs of two methods are"
            " independent, so their means are resampled independently. First all tasks with something to transfer"
            " together, then each of them; the last one, which the learning curves show, is shaded." + strip * article
        ),
        "needs": ("per_seed", "claims") if article else ("per_seed",),
        "groups": ("statistics",),
        "environments": tuple(name for name, tasks in zip(names, later, strict=True) if tasks),
        "methods": tuple(dict.fromkeys(("no_transfer", *every_method))),
        "with_foreign": True,
        "on_top": True,
    }
    rows = {
        **(
            {
                "front": Figure("front", item="Overview", **front),
                "front_narrow": Figure("front_narrow", item="Overview, narrow", **front),
            }
            if any(later) and compared - {"no_transfer"}
            else {}
        ),
        "clusters": Figure(
            "clusters",
            "two clusters of states and the subgoal between them",
            "Two rooms of our own. A dot is a state, a line a move between two; dots are the larger, the greater the"
            " original FD metric (frequency times distance) after a task that leads from one room to the other, mean"
            f" over {CLUSTER_LIVES} lives of PTL. The ring is where most of these lives end their skill. The article's"
            " figure is lost.",
            needs=(),
            groups=("learning", "skills", "subgoals"),
        ),
        "algorithms": Figure(
            "algorithms",
            "the method as two algorithms",
            "The method as this package runs it, with the constants of the run: how a task is learned with the library,"
            " and how a skill is added after it. The article's algorithms are lost; words, numbers and order are ours.",
            needs=(),
            groups=("learning", "skills", "subgoals"),
        ),
        "prior": Figure(
            "prior",
            "prior of a skill by where it ends",
            f"Prior of a skill for one goal, by the cell in which the skill ends, relative to the best cell. {origin}"
            " No runs enter.",
            needs=("maps",),
            groups=("skills",),
            environments=(_shown_in(entries, "prior"),),
            item="Prior",
        ),
        "misleading_prior": Figure(
            "misleading_prior",
            "the likelihood against a misleading prior",
            "A small map of our own in which the subgoal nearest to the goal in a straight line is behind a wall. Left,"
            " the map with the library's subgoals; right, the probability of each skill over the episodes: mean over"
            f" {seeds} runs of PTL{note(seeds, level)}, drawn at some episodes. On average the likelihood moves"
            " probability from the nearest skill to the one that helps; single runs differ.",
            needs=("misleading_prior",),
            groups=("statistics",),
            methods=("ptl",),
        ),
        **{
            _item(entries, name, "map"): Figure(
                "maps",
                f"map of {entries[name]['title']}",
                "The map with the start I and the goals of the tasks."
                + " docs/reconstruction.md says where the drawing comes from." * bool(entries[name]["article_items"])
                + OUR_DRAWING * (entries[name].get("map") in OUR_MAPS),
                needs=("maps",),
                environments=(name,),
                item="Map",
            )
            for name in names
        },
        "frequencies": Figure(
            "frequencies",
            "subgoal selection frequencies",
            "How often each state is the subgoal of the original FD metric: tasks from"
            f" {survey['starts']} start states to every other state, {survey['trajectories']} successful episodes of"
            " Q-learning without transfer each. Adjacent states have no state between them and so no subgoal.",
            needs=("survey",),
            environments=names,
            item="Frequencies",
        ),
        **{
            _item(entries, name, "discovery"): Figure(
                "discovery",
                f"subgoal discovery in {entries[name]['title']}",
                "The FD metric (frequency times distance) after late tasks, original and incremental, on the same"
                f" trajectories, those of the PTL runs; mean over {seeds} seeds. Dots mark the peak of the original"
                " metric and the subgoal that was stored by the incremental one, which may be none; their area grows"
                " with the number of seeds.",
                needs=("learning",),
                environments=(name,),
                methods=("ptl",),
                item="Discovery",
            )
            for name in names
        },
        "curves": Figure(
            "curves",
            f"steps per episode on {'the last task' if article else 'every task'}",
            f"Steps per episode on {'the last' if article else 'every'} task of each environment: mean over"
            f" {seeds} seeds{note(seeds, level)} and median, log scale. A few long runs raise the mean,"
            " not the median. The dotted line is the shortest path." + GREEDY * ("policy_reuse" in curves),
            needs=("steps", "maps"),
            groups=("statistics",),
            environments=names,
            methods=curves,
            with_foreign=True,
            item="Curves",
        ),
        "measures": Figure(
            "measures",
            "the measures of transfer on real curves",
            f"The measures of transfer on curves of this run, mean over {seeds} seeds{note(seeds, level)}. Left, log"
            " scale: time to threshold and asymptotic performance. Right, linear scale, the episodes in which the"
            " curves differ most: the jump start, and the steps saved, which are the area between the curves; the"
            " transfer ratio is their share of the area below the curve without transfer.",
            needs=("steps", "maps"),
            groups=("measures", "statistics"),
            environments=(_shown_in(entries, "measures"),),
            methods=("no_transfer", "ptl"),
            item="Measures",
        ),
        "growth": Figure(
            "growth",
            "growth of the skill library",
            "Skills in the library against tasks learned, random start and goal for each task: mean over"
            f" {growth['runs']} lives{note(growth['runs'], level)}. Two fits to the means: two slopes that meet at"
            f" {growth['breakpoint']} tasks, and a saturating curve, which has no bend and one free number less.",
            needs=("growth",),
            groups=("growth", "statistics"),
            item="Growth",
        ),
        "library_cost": Figure(
            "library_cost",
            "cost of a selection and size of a library",
            "Operations of one skill selection, counted, against the size of the library, and the bytes of a library"
            " against states and skills.",
            needs=("selection_cost", "library_bytes"),
            item="Library",
        ),
    }
    return {
        ARTICLE_NUMBERS.get(kind, kind) if article else kind: row
        for kind, row in rows.items()
        if set(row.methods) <= compared and (article or kind not in ARTICLE_ONLY) and kind not in off
    }


def left_out(config: Mapping[str, Any], article: bool) -> dict[str, str]:
    """Return the figures that a run cannot have, each with the missing methods."""
    compared = list(config["methods"])
    wanted = figures({**config, "methods": [*compared, *sorted(ALWAYS_SHOWN - set(compared))]}, article)
    there = figures(config, article)
    return {
        name: ", ".join(m for m in row.methods if m not in compared)
        for name, row in wanted.items()
        if name not in there
    }


def item_label(name: str, row: Figure) -> str:
    """Return the name of a figure for readers: ``figure09`` is Figure 9, others have the name in their row."""
    return f"Figure {int(name.removeprefix('figure'))}" if name.startswith("figure") else row.item


def heading(name: str, row: Figure) -> str:
    """Return the title of a figure on the page."""
    numbered = name.startswith("figure")
    return f"{item_label(name, row)}: {row.shows}" if numbered else f"{row.shows[0].upper()}{row.shows[1:]}"


def on_page(rows: Mapping[str, Figure]) -> dict[str, Figure]:
    """Return the figures of the page in its order: results first, then the maps, then what was assumed or counted."""
    kept = {name: row for name, row in rows.items() if not row.on_top}
    places = {module: place for place, module in enumerate(ON_PAGE)}
    names = sorted(kept, key=lambda name: places.get(kept[name].module, len(ON_PAGE)))
    return {name: kept[name] for name in names}


def _item(environments: Mapping[str, Any], name: str, kind: str) -> str:
    """Return the article's figure of an environment, or a name made from the environment's."""
    return environments[name]["article_items"].get(kind, f"{kind}_{name}")


def _shown_in(environments: Mapping[str, Any], kind: str) -> str:
    """Return the environment that the configuration names for a figure, the last one if it names none."""
    named = [name for name, entry in environments.items() if kind in entry["article_items"]]
    return named[0] if named else list(environments)[-1]
