"""The page of the second study: answers that follow from the estimates, figures and tables."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pandas as pd

from ptl import methods
from ptl.methods.beyond import reference
from ptl.report.figures.beyond import Look
from ptl.report.table import Cell, Column, Group, Row, Table, text_table
from ptl.report.templating import render
from ptl.study.population.design import Study
from ptl.study.population.summary import BASE
from ptl.text import MISSING, interval, number, percent

FAMILY_TITLES = {
    "chain": "Chain of rooms",
    "rooms": "Random rooms",
    "maze": "Perfect maze",
    "braided": "Braided maze",
    "cave": "Cave",
    "ground": "Open ground",
    "moving_ai": "Moving AI maps",
}

NO_TRANSFER = "no_transfer"

FINDERS = ("ptl_random_state", "ptl_original_fd", "ptl_goal", "ptl_farthest", "ptl_covering")
"""PTL whose subgoals come from elsewhere; all else is as in `ptl`."""

RIVALS = ("optimistic", "maxqinit", "optimistic_fast", "rmax", "rmax_memory")
"""Baselines without skills."""

CURVES = (
    "no_transfer", "ptl", "ptl_random_state", "ptl_farthest", "all_goals", "ptl_frontier", "optimistic_fast",
    "rmax_memory",
)  # fmt: skip
"""Methods in figures with curves; all of them would hide each other."""

NOTHING, COORDINATES = "nothing", "its coordinates"
CERTAIN = "yes"
SKILLS = "subgoals and policies of the library"
TRANSITIONS = "all transitions ever seen"

KNOWLEDGE: dict[str, tuple[str, str, str]] = {
    "no_transfer": (NOTHING, "no", NOTHING),
    "ptl": (COORDINATES, "for skills", SKILLS),
    "ptl_supervised": ("the whole map (supervisor)", "for skills", SKILLS),
    "ptl_original_fd": (COORDINATES, "for skills", SKILLS),
    "ptl_random_state": (COORDINATES, "for skills", SKILLS),
    "ptl_goal": (COORDINATES, "for skills", SKILLS),
    "ptl_farthest": (COORDINATES, "for skills", SKILLS),
    "ptl_covering": (COORDINATES, "for skills", SKILLS),
    "all_goals": (COORDINATES, "for skills", TRANSITIONS),
    "ptl_path_prior": (COORDINATES, "for skills", f"{SKILLS}, {TRANSITIONS}"),
    "ptl_frontier": (COORDINATES, "for skills", f"{SKILLS}, {TRANSITIONS}"),
    "ptl_frontier_path": (COORDINATES, "for skills", f"{SKILLS}, {TRANSITIONS}"),
    "frontier_only": (COORDINATES, "for skills", TRANSITIONS),
    "optimistic": (NOTHING, "no", NOTHING),
    "maxqinit": (NOTHING, "no", "greatest value of each tried action"),
    "optimistic_fast": (NOTHING, CERTAIN, NOTHING),
    "rmax": (NOTHING, CERTAIN, NOTHING),
    "rmax_memory": ("its state, if seen before", CERTAIN, TRANSITIONS),
}
"""What a method is told of the goal, whether it relies on moves being certain, and what it keeps from task to task."""


def looks_of(study: Study) -> dict[str, Look]:
    """Return how each method is shown, by identifier, in the order of the study."""
    looks = {}
    for method in study.methods:
        kind = methods.load(reference(method))
        name = methods.identifier(reference(method))
        looks[name] = Look(kind.label, kind.colour, dashed=name not in KNOWLEDGE or name in RIVALS)
    for name in study.foreign_lives:
        looks[name] = Look(name.replace("_", " ").capitalize(), "#000000", dashed=True)
    return looks


def titles_of(families: Iterable[str], entries: Iterable[str]) -> dict[str, str]:
    """Return the names of families as readers see them; families of the article's maps say so."""
    article = set(entries)
    return {
        family: f"Article’s {family}" if family in article else FAMILY_TITLES.get(family, family) for family in families
    }


def in_figures(looks: Mapping[str, Look]) -> dict[str, Look]:
    """Return the methods that figures with curves show: those of `CURVES` and those of other people."""
    return {name: look for name, look in looks.items() if name in CURVES or name not in KNOWLEDGE}


# -- sentences -----------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Comparison:
    """A method against another one over the generated families."""

    ratios: pd.DataFrame  # family, ratio, ratio_low, ratio_high
    less: int = field(init=False)
    more: int = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "less", int((self.ratios["ratio_high"] < 1).sum()))
        object.__setattr__(self, "more", int((self.ratios["ratio_low"] > 1).sum()))

    @property
    def families(self) -> int:
        """Number of families compared."""
        return len(self.ratios)

    @property
    def text(self) -> str:
        """The ratio, its spread over families, and in how many of them it is clear of 1."""
        values = self.ratios["ratio"]
        spread = f"{number(values.min())} to {number(values.max())} by family"
        mean = number(float(np.exp(np.log(values).mean())))
        counts = [f"less in {self.less}" if self.less else "", f"more in {self.more}" if self.more else ""]
        rest = self.families - self.less - self.more
        counts.append(f"undecided in {rest}" if rest else "")
        listed = ", ".join(filter(None, counts))
        return f"{mean} × PTL’s cost ({spread}; {listed} of {self.families} families)"


def compared(costs: pd.DataFrame, families: Sequence[str]) -> dict[str, Comparison]:
    """Return the comparison of every method with `BASE` over some families."""
    own = costs[costs["family"].isin(families) & (costs["method"] != BASE)].dropna(subset=["ratio"])
    return {str(name): Comparison(part) for name, part in own.groupby("method", sort=False)}


def answers(
    costs: pd.DataFrame,
    looks: Mapping[str, Look],
    families: Sequence[str],
    components: pd.DataFrame,
    titles: Mapping[str, str],
) -> list[dict[str, Any]]:
    """Return the three questions, each with its lines; every statement follows from an interval."""
    found = compared(costs, families)
    return [
        {"question": "1. Against strong baselines?", "lines": list(_against(found, looks))},
        {"question": "2. Because of which part?", "lines": list(_parts(found, looks))},
        {
            "question": "3. On maps that nobody chose?",
            "lines": list(_elsewhere(costs, families, components, titles, looks)),
        },
    ]


def _against(found: Mapping[str, Comparison], looks: Mapping[str, Look]) -> Iterable[str]:
    if NO_TRANSFER in found:
        yield f"Learning every task from nothing: {found[NO_TRANSFER].text}."
    rivals = {name: found[name] for name in (*RIVALS, *(n for n in found if n not in KNOWLEDGE)) if name in found}
    cheaper = [name for name, comparison in rivals.items() if comparison.less == comparison.families]
    dearer = [name for name, comparison in rivals.items() if comparison.more == comparison.families]
    for name, comparison in rivals.items():
        yield f"{looks[name].label}: {comparison.text}."
    if cheaper:
        yield f"Cheaper than PTL in every family: {_listed(cheaper, looks)}."
        told = [name for name in cheaper if name in KNOWLEDGE and KNOWLEDGE[name][1] == CERTAIN]
        if told:
            verb = "rely" if len(told) > 1 else "relies"
            yield (
                f"Of these, {_listed(told, looks)} {verb} on moves being certain, which the article’s robot may not;"
                " the table below says what each method may know."
            )
    if dearer:
        yield f"Dearer than PTL in every family: {_listed(dearer, looks)}."


def _parts(found: Mapping[str, Comparison], looks: Mapping[str, Look]) -> Iterable[str]:
    for name in (*FINDERS, "ptl_supervised", "all_goals", "ptl_path_prior", "ptl_frontier", "frontier_only"):
        if name in found:
            yield f"{looks[name].label}: {found[name].text}."
    if "ptl_frontier" in found and "frontier_only" in found:
        both, alone = (found[name].ratios.set_index("family") for name in ("ptl_frontier", "frontier_only"))
        clear = int((both["ratio_high"] < alone["ratio_low"]).sum())
        yield (
            "Our skill to the frontier with the library is clearly cheaper than without it in"
            f" {clear} of {len(both)} families (intervals apart)."
        )


def _elsewhere(
    costs: pd.DataFrame,
    families: Sequence[str],
    components: pd.DataFrame,
    titles: Mapping[str, str],
    looks: Mapping[str, Look],
) -> Iterable[str]:
    base = costs[costs["method"] == BASE].set_index("family")
    none = costs[costs["method"] == NO_TRANSFER].set_index("family")
    if len(none):
        saved = []
        for family in none.index:
            row = none.loc[family]
            low, high = sorted((1 / row["ratio_low"], 1 / row["ratio_high"]))
            saved.append(f"{titles[family]} {number(1 / row['ratio'])} {interval(low, high)}".rstrip())
        yield f"PTL’s cost as a multiple of that of no transfer: {'; '.join(saved)}."
    yield (
        "PTL’s cost as a multiple of the optimum: "
        + "; ".join(f"{titles[family]} {number(base.loc[family, 'cost'])}" for family in base.index)
        + "."
    )
    for family in families:
        own = costs[costs["family"] == family].sort_values("cost")
        cheapest = own.iloc[0]
        yield f"{titles[family]}: cheapest is {looks[cheapest['method']].label} ({number(cheapest['cost'])} × optimum)."
    if len(components):
        shares = components.groupby("method", sort=False)["intraclass"].median()
        yield (
            "Share of the variance of log(cost ÷ PTL’s) that lies between maps rather than between lives on a map,"
            f" median over families: from {percent(round(shares.min(), 2))} ({looks[str(shares.idxmin())].label}) to"
            f" {percent(round(shares.max(), 2))} ({looks[str(shares.idxmax())].label})."
        )


def _listed(names: Sequence[str], looks: Mapping[str, Look]) -> str:
    return ", ".join(looks[name].label for name in names)


# -- tables --------------------------------------------------------------------------------------------------


def wide_table(
    frame: pd.DataFrame,
    looks: Mapping[str, Look],
    columns: Mapping[str, str],
    by: str,
    value: str,
    limits: tuple[str, str] | None,
    title: str,
    intro: str,
    notes: Sequence[str] = (),
    best: bool = True,
) -> Table:
    """Lay out a value of each method in columns; the lowest of a column is marked as the best."""
    rows = []
    lowest = frame.groupby(by)[value].min() if best else {}
    for method, look in looks.items():
        own = frame[frame["method"] == method].drop_duplicates(by).set_index(by)
        if own.empty or own[value].isna().all():
            continue
        cells = []
        for name in columns:
            if name not in own.index or np.isnan(own.loc[name, value]):
                cells.append(Cell(MISSING))
                continue
            row = own.loc[name]
            detail = interval(row[limits[0]], row[limits[1]]) if limits else ""
            cells.append(Cell(number(float(row[value])), detail, best=best and row[value] == lowest[name]))
        rows.append(Row(look.label, cells, look.colour))
    return Table(title, intro, "method", [Column(heading) for heading in columns.values()], [Group(rows)], notes)


def knowledge_table(looks: Mapping[str, Look]) -> Table:
    """Lay out what each method may know and remember."""
    rows = [(look.label, *KNOWLEDGE.get(name, ("not stated",) * 3)) for name, look in looks.items()]
    headings = ("method", "told about the goal", "relies on certain moves", "keeps from task to task")
    return text_table(
        "What each method may know and remember",
        "Moves in these worlds are deterministic, which some methods rely on and others do not.",
        headings,
        rows,
        (
            "For skills: Q-learning itself does not rely on it, but the policy of a skill replays transitions that were"
            " seen once.",
            "All methods are told when they are at the goal, and keep Q within a task.",
        ),
        headings[1:],
    )


def component_table(components: pd.DataFrame, looks: Mapping[str, Look], titles: Mapping[str, str]) -> Table:
    """Lay out the share of variance between maps."""
    return wide_table(
        components,
        looks,
        {family: titles[family] for family in dict.fromkeys(components["family"])},
        "family",
        "intraclass",
        None,
        "Variance between maps",
        "Share of the variance of log(cost ÷ PTL’s cost) that lies between maps (intraclass correlation); the rest"
        " lies between lives on the same map.",
        (
            "A high share is a reason for many maps with few lives on each. Standard errors of both designs:"
            " components.csv.",
        ),
        best=False,
    )


# -- the page ------------------------------------------------------------------------------------------------


def page(**values: Any) -> str:
    """Fill the page's template."""
    return render("beyond.html", title="Is a skill library worth having, and where?", **values)


def introduction(study: Study, lives: pd.DataFrame) -> str:
    """Describe what was run."""
    own = lives[lives["sequence"] == "increasing"]
    maps = own.groupby("family")["map"].nunique()
    families = f"{len(maps)} families of generated maps" if len(maps) else "no generated maps"
    count = f", {number(int(maps.min()))} maps each" if len(maps) else ""
    size = f" of about {number(study.size)} states" if study.families else ""
    compared_methods = number(int(lives["method"].nunique()))
    return (
        "A second study with the package, apart from the reproduction of the article: none of its methods, maps and"
        f" numbers is the article’s, except where the article’s maps are named. It compares"
        f" {compared_methods} methods on {families}{count}{size}, band “{study.band}”, {number(study.seeds)} lives on"
        f" each map, and on {number(len(study.article_maps))} maps of the article with {number(study.article_seeds)}"
        f" lives. A life is six tasks of {number(study.learning.episodes)} episodes; {number(len(lives))} lives in all."
    )


READING = (
    "How to read this. Cost is the number of steps over all tasks after the first, as a multiple of the optimum"
    " (episodes × shortest paths): 1 cannot be beaten. Means are geometric, brackets are intervals. A method is called"
    " cheaper or dearer in a family if the whole interval of its ratio to PTL on the same maps lies on one side of 1."
    " The lines above are made from the numbers of this run."
)


def method_lines(study: Study) -> list[str]:
    """Describe design and statistics."""
    level, resamples = percent(study.statistics.confidence), number(study.statistics.resamples)
    return [
        f"Intervals ({level}) are percentiles of a hierarchical bootstrap with {resamples} resamples: maps, then lives"
        " on each map; all methods on the same maps. For a map of the article only lives are drawn, so its intervals"
        " say nothing about other maps. They are not corrected for the number of comparisons.",
        "Maps, their seeds and hashes are in config/population.csv. What was tuned was tuned on the tuning band, which"
        " has no map in common with the test band; docs/beyond.md says what was tried.",
        "Every method is a file in ptl/methods/ or ptl/methods/beyond/, with its source. Hyper-parameters are those of"
        " the reproduction, tuned for none of the methods.",
        "Limits: deterministic grid worlds, tables instead of function approximation, one start a map. A method that"
        " keeps a model of all transitions fits such worlds better than a robot’s; noise would cost it more than the"
        " others.",
        "Numbers of each life: per_life.csv. Truncated episodes are counted in it.",
    ]
