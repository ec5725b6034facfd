"""The page of the second study: answers that follow from the estimates, figures and tables."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from ptl import methods
from ptl.report.table import Cell, Column, Row, RowGroup, Table, text_table
from ptl.report.templating import render
from ptl.text import MISSING, interval, number, percent
from studies.beyond import methods as our_methods
from studies.beyond.design import SecondStudy
from studies.beyond.figures import Look
from studies.beyond.maps import MAIN
from studies.beyond.planned import shown
from studies.beyond.summary import BASE, CERTAIN_WORLD

TEMPLATES = Path(__file__).parent / "templates"

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
"""PTL with other finders of subgoals; everything else is as in `ptl`."""

READINGS = ("ptl_lead_in", "ptl_reselect", "ptl_mixing", "ptl_initial_values")
"""PTL under each other reading of what a drawn skill does."""

TRANSFER = ("full_transfer", "policy_reuse", "policy_reuse_tuned", "plpr", "successor_features")
"""Methods that hand over values or policies instead of skills."""

RMAX = tuple(f"{kind}{visits}" for kind in ("rmax", "rmax_memory") for visits in ("", "_2", "_5", "_10"))

RIVALS = (
    *TRANSFER, "optimistic", "maxqinit", "optimistic_fast", *RMAX, "rmax_memory_5_stubborn", "rmax_directed",
    "free_space", "free_space_memory",
)  # fmt: skip
"""Baselines without skills."""

OPTIONS = ("options_smdp", "options_intra")
"""Skills as options, without a selection of their own."""

OURS = ("ptl_path_prior", "ptl_frontier", "ptl_frontier_path", "frontier_only")
"""Proposals of ours and their control."""

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
    **dict.fromkeys(READINGS, (COORDINATES, "for skills", SKILLS)),
    "ptl_supervised": ("the whole map (supervisor)", "for skills", SKILLS),
    "ptl_original_fd": (COORDINATES, "for skills", SKILLS),
    "ptl_random_state": (COORDINATES, "for skills", SKILLS),
    "ptl_goal": (COORDINATES, "for skills", SKILLS),
    "ptl_farthest": (COORDINATES, "for skills", SKILLS),
    "ptl_covering": (COORDINATES, "for skills", SKILLS),
    **dict.fromkeys(OPTIONS, (NOTHING, "for skills", SKILLS)),
    "all_goals": (COORDINATES, "for skills", TRANSITIONS),
    "ptl_path_prior": (COORDINATES, "for skills", f"{SKILLS}, {TRANSITIONS}"),
    "ptl_frontier": (COORDINATES, "for skills", f"{SKILLS}, {TRANSITIONS}"),
    "ptl_frontier_path": (COORDINATES, "for skills", f"{SKILLS}, {TRANSITIONS}"),
    "frontier_only": (COORDINATES, "for skills", TRANSITIONS),
    "full_transfer": (NOTHING, "no", "last action values"),
    "policy_reuse": (NOTHING, "no", "policies"),
    "policy_reuse_tuned": (NOTHING, "no", "policies"),
    "plpr": (NOTHING, "no", "policies"),
    "successor_features": ("its state", CERTAIN, f"policies, {TRANSITIONS}"),
    "optimistic": (NOTHING, "no", NOTHING),
    "maxqinit": (NOTHING, CERTAIN, "greatest value of each tried action"),
    "optimistic_fast": (NOTHING, CERTAIN, NOTHING),
    **{name: (NOTHING, "no", NOTHING) for name in RMAX if "memory" not in name},
    **{name: ("its state, if seen before", "no", TRANSITIONS) for name in RMAX if "memory" in name},
    "rmax_memory_5_stubborn": ("its state, if seen before", "no", TRANSITIONS),
    "rmax": (NOTHING, CERTAIN, NOTHING),
    "rmax_memory": ("its state, if seen before", CERTAIN, TRANSITIONS),
    "rmax_directed": (COORDINATES, CERTAIN, NOTHING),
    "free_space": (f"{COORDINATES}, size of the map", "no", NOTHING),
    "free_space_memory": (f"{COORDINATES}, size of the map", "no", "walls"),
}
"""Each method's knowledge of the goal, reliance on deterministic moves, and memory between tasks."""

ORDER = tuple(KNOWLEDGE)
"""Methods in the order in which figures and tables show them; those of other people come after them."""


OTHER_COLOURS = ("#000000", "#7f3b08", "#003c30", "#40004b")
"""Colours of methods that only a table names, one after another."""


def looks_of(study: SecondStudy, names: Iterable[str]) -> dict[str, Look]:
    """Return how each method is shown, by identifier: those of the study first, then others that ``names`` has."""
    built_in = (*methods.names(), *our_methods.names())
    references = methods.by_identifier(map(our_methods.reference, study.methods))
    others = [name for name in dict.fromkeys(names) if name not in references]
    order = {name: place for place, name in enumerate(dict.fromkeys((*ORDER, *references, *others)))}
    colours = itertools.cycle(OTHER_COLOURS)
    looks = {}
    for name in sorted({*references, *others}, key=order.__getitem__):
        dashed = name not in KNOWLEDGE or name in RIVALS
        if name in references or name in built_in:
            kind = methods.load(references.get(name) or our_methods.reference(name))
            looks[name] = Look(kind.label, kind.colour, dashed, KNOWLEDGE.get(name, kind.knows))
        else:
            looks[name] = Look(name.replace("_", " ").capitalize(), next(colours), dashed)
    return looks


def titles_of(families: Iterable[str], entries: Iterable[str]) -> dict[str, str]:
    """Return the names of families as readers see them; families of the article's maps are marked."""
    article = set(entries)
    return {
        family: f"Article’s {family}" if family in article else FAMILY_TITLES.get(family, family) for family in families
    }


def in_figures(looks: Mapping[str, Look]) -> dict[str, Look]:
    """Return the methods that figures with curves show: those of `CURVES` and those of other people."""
    return {name: look for name, look in looks.items() if name in CURVES or name not in KNOWLEDGE}


# -- sentences -----------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class AgainstPTL:
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


def compared(costs: pd.DataFrame, families: Sequence[str]) -> dict[str, AgainstPTL]:
    """Return the comparison of every method with `BASE` over some families."""
    own = costs[costs["family"].isin(families) & (costs["method"] != BASE)].dropna(subset=["ratio"])
    return {str(name): AgainstPTL(part) for name, part in own.groupby("method", sort=False)}


MODEL, PLAN = "rmax_memory", "free_space_memory"
"""A remembered model, and a plan through cells that are taken for free until bumped into."""


def lead(costs: pd.DataFrame, looks: Mapping[str, Look], families: Sequence[str]) -> str:
    """Say where the reader's own methods come by mean cost over the generated families, and answer the question."""
    own = costs[costs["family"].isin(families)] if len(families) else costs
    means = np.exp(np.log(own["cost"]).groupby(own["method"], sort=False).mean()).sort_values()
    shown = {name: number(round(cost, 2)) for name, cost in means.items()}
    text = " ".join(
        f"“{looks[name].label}” takes {shown[name]} times the optimum on average: number {place} of"
        f" {_counted(len(means), 'method')} by cost."
        for place, name in enumerate(means.index, start=1)
        if name not in KNOWLEDGE
    )
    if BASE not in means or NO_TRANSFER not in means:
        return text
    text += (
        f"{' ' * bool(text)}PTL’s library takes {shown[BASE]} times the optimum on average, learning from nothing"
        f" {shown[NO_TRANSFER]} times; of {len(means)} methods here PTL is number"
        f" {list(means.index).index(BASE) + 1} by cost."
    )
    better = [name for name in (MODEL, PLAN) if name in means and means[name] < means[BASE]]
    if better:
        listed = " and ".join(f"{looks[name].label} {shown[name]}" for name in better)
        text += f" A robot that may keep what it has seen of the house needs no skills on maps of this size: {listed}."
    return text


def answers(
    costs: pd.DataFrame,
    looks: Mapping[str, Look],
    families: Sequence[str],
    components: pd.DataFrame,
    titles: Mapping[str, str],
) -> list[dict[str, Any]]:
    """Return the three questions, each with its lines; every statement follows from an interval."""
    comparisons = compared(costs, families)
    return [
        {"question": "1. Is it better than strong baselines?", **_against(comparisons, looks)},
        {"question": "2. Which part of it does the work?", **_parts(comparisons, looks)},
        {
            "question": "3. Does it hold on maps that nobody chose?",
            **_elsewhere(comparisons, costs, families, components, titles, looks),
        },
    ]


def _verdicts(comparisons: Mapping[str, AgainstPTL], names: Sequence[str], looks: Mapping[str, Look]) -> str:
    """Say which of some methods are cheaper than PTL in every family, more expensive in every family, or neither."""
    cheaper = [name for name in names if comparisons[name].less == comparisons[name].families]
    dearer = [name for name in names if comparisons[name].more == comparisons[name].families]
    rest = [name for name in names if name not in cheaper and name not in dearer]
    parts = [
        f"cheaper than PTL in every family: {_listed(cheaper, looks)}" if cheaper else "",
        f"dearer in every family: {_listed(dearer, looks)}" if dearer else "",
        f"undecided, or not the same in every family: {_listed(rest, looks)}" if rest else "",
    ]
    return _sentence("; ".join(filter(None, parts)))


def _is_told_less(look: Look) -> bool:
    """Return whether a method relies on certain moves and is not told where the goal lies."""
    goal, moves, _ = look.knows
    return moves == CERTAIN and COORDINATES not in goal


def _against(comparisons: Mapping[str, AgainstPTL], looks: Mapping[str, Look]) -> dict[str, Any]:
    names = [name for name in comparisons if name not in KNOWLEDGE]  # the reader's own come first
    names += [name for name in (NO_TRANSFER, *RIVALS, *OPTIONS) if name in comparisons]
    lines = [f"{looks[name].label}: {comparisons[name].text}." for name in names]
    certain = [name for name in names if _is_told_less(looks[name]) and comparisons[name].less]
    if certain:
        verb = "are" if len(certain) > 1 else "is"
        lines.append(
            f"To be fair: {_listed(certain, looks)} {verb} made for moves that are certain, and a kept model for a"
            " memory of every transition, which the article’s robot may not have. On the other hand PTL is told where"
            " the goal lies; these methods are not, though a kept model knows a goal that it has seen. The table below"
            " says what each method may know."
        )
    return {"lead": _verdicts(comparisons, names, looks), "lines": lines}


def _parts(comparisons: Mapping[str, AgainstPTL], looks: Mapping[str, Look]) -> dict[str, Any]:
    finders = [name for name in FINDERS if name in comparisons]
    others = [name for name in (*READINGS, "ptl_supervised", "all_goals", *OURS) if name in comparisons]
    lines = [f"{looks[name].label}: {comparisons[name].text}." for name in (*finders, *others)]
    if "ptl_frontier" in comparisons and "frontier_only" in comparisons:
        both, alone = (comparisons[name].ratios.set_index("family") for name in ("ptl_frontier", "frontier_only"))
        with_library = int((both["ratio_high"] < alone["ratio_low"]).sum())
        without = int((alone["ratio_high"] < both["ratio_low"]).sum())
        lines.append(
            f"Our skill to the frontier beside the library against the same skill alone: clearly cheaper in"
            f" {with_library}, clearly dearer in {without} of {len(both)} families (intervals apart)."
            + (
                ""
                if with_library > without
                else " Not the library makes it cheap, but the memory of transitions and the direction of the goal."
            )
        )
    lead = f"Same agent, other subgoals: {_verdicts(comparisons, finders, looks)}" if finders else ""
    return {"lead": lead, "lines": lines}


def _elsewhere(
    comparisons: Mapping[str, AgainstPTL],
    costs: pd.DataFrame,
    families: Sequence[str],
    components: pd.DataFrame,
    titles: Mapping[str, str],
    looks: Mapping[str, Look],
) -> dict[str, Any]:
    own = costs[costs["method"] == BASE].set_index("family")
    none = costs[costs["method"] == NO_TRANSFER].set_index("family")
    lead, lines = "", []
    if NO_TRANSFER in comparisons:
        comparison = comparisons[NO_TRANSFER]
        lead = (
            f"PTL costs less than learning every task from nothing in {comparison.more} of {comparison.families}"
            f" families of generated maps, more in {comparison.less}."
        )
        saved = []
        for family in none.index:
            row = none.loc[family]
            low, high = sorted((1 / row["ratio_low"], 1 / row["ratio_high"]))
            saved.append(f"{titles[family]} {number(1 / row['ratio'])} {interval(low, high)}".rstrip())
        lines.append(f"PTL’s cost as a multiple of that of no transfer: {'; '.join(saved)}.")
    listed = "; ".join(f"{titles[family]} {number(own.loc[family, 'cost'])}" for family in own.index)
    lines.append(f"PTL’s cost as a multiple of the optimum: {listed}.")
    if len(families):
        best: dict[str, list[str]] = {}
        for family in families:
            row = costs[costs["family"] == family].sort_values("cost").iloc[0]
            best.setdefault(row["method"], []).append(f"{titles[family]} ({number(row['cost'])} × optimum)")
        lines += [f"Cheapest is {looks[name].label} in: {', '.join(places)}." for name, places in best.items()]
    if len(components):
        shares = components.groupby("method", sort=False)["intraclass"].median()
        lines.append(
            "Share of the variance of log(cost ÷ PTL’s) that lies between maps rather than between lives on a map,"
            f" median over families: from {percent(round(shares.min(), 2))} ({looks[str(shares.idxmin())].label}) to"
            f" {percent(round(shares.max(), 2))} ({looks[str(shares.idxmax())].label})."
        )
    return {"lead": lead, "lines": lines}


def harder_answer(worlds: pd.DataFrame, looks: Mapping[str, Look]) -> dict[str, Any]:
    """Return the question about worlds that slip or change, with its lines.

    Parameters
    ----------
    worlds : DataFrame
        As `studies.beyond.summary.harder_costs` makes it.
    """
    others = worlds[(worlds["world"] != CERTAIN_WORLD) & (worlds["method"] != BASE)].dropna(subset=["ratio"])
    ratios = others.groupby("method", sort=False)
    below, above = ratios["ratio_high"].max() < 1, ratios["ratio_low"].min() > 1
    cheaper, dearer, rest = (list(own[own].index) for own in (below, above, ~below & ~above))
    parts = [
        f"cheaper than PTL in every one of these worlds and families: {_listed(cheaper, looks)}" if cheaper else "",
        f"dearer in every one: {_listed(dearer, looks)}" if dearer else "",
        f"not the same in all: {_listed(rest, looks)}" if rest else "",
    ]
    lines = []
    for world, own in worlds.groupby("world", sort=False):
        means = np.exp(np.log(own["cost"]).groupby(own["method"], sort=False).mean()).sort_values()
        best = ", ".join(f"{looks[str(name)].label} {number(value)}" for name, value in means.head(3).items())
        base = f"; PTL {number(means[BASE])}" if BASE in means else ""
        lines.append(f"{str(world).capitalize()}: cheapest {best}{base} (× optimum, mean over families).")
    for method, own in others[others["method"].isin(rest)].groupby("method", sort=False):
        lost = own[own["ratio_low"] > 1]
        if len(lost):
            named = ", ".join(f"{row.family} ({row.world})" for row in lost.head(4).itertuples())
            more = f" and {len(lost) - 4} more" if len(lost) > 4 else ""
            lines.append(f"{looks[str(method)].label} is dearer than PTL in {named}{more}.")
    return {
        "question": "4. Does it turn where moves slip or the house changes?",
        "lead": _sentence("; ".join(filter(None, parts))),
        "lines": lines,
    }


def harder_table(worlds: pd.DataFrame, looks: Mapping[str, Look], titles: Mapping[str, str]) -> Table:
    """Lay out the costs in worlds that slip or change, a group of rows for each family."""
    names = {name: str(name).capitalize() for name in dict.fromkeys(worlds["world"])}
    groups: list[RowGroup] = []
    columns: Sequence[Column] = ()
    for family in (family for family in titles if family in set(worlds["family"])):
        own = worlds[worlds["family"] == family]
        part = wide_table(own, looks, names, "world", "cost", ("low", "high"), "", "")
        columns = part.columns
        groups.append(RowGroup(part.groups[0].rows, titles[family], family))
    return Table(
        "Cost where moves slip and maps change",
        "As a multiple of the optimum of the same world, on the same maps; geometric mean over maps and lives.",
        "method",
        columns,
        groups,
        ("Bold: least in the column. Brackets: intervals.",),
        group_heading="family",
    )


def _sentence(text: str) -> str:
    return f"{text[0].upper()}{text[1:]}." if text else ""


def _listed(names: Sequence[str], looks: Mapping[str, Look]) -> str:
    return ", ".join(f"“{looks[name].label}”" for name in names)


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
    return Table(title, intro, "method", [Column(heading) for heading in columns.values()], [RowGroup(rows)], notes)


def knowledge_table(looks: Mapping[str, Look]) -> Table:
    """Lay out what each method may know and remember."""
    rows = [(look.label, *look.knows) for look in looks.values()]
    headings = ("method", "told about the goal", "relies on certain moves", "keeps from task to task")
    return text_table(
        "What each method may know and remember",
        "Moves are deterministic except where a world slips; some methods rely on it and others do not.",
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
    return render("beyond.html", folder=TEMPLATES, title="Is a skill library worth having, and where?", **values)


def introduction(study: SecondStudy, lives: pd.DataFrame) -> str:
    """Describe the runs."""
    own = lives[lives["sequence"] == MAIN]
    maps = own.groupby("family")["map"].nunique()
    families, each = _counted(len(maps), "family", "families"), _counted(int(maps.min()) if len(maps) else 0, "map")
    places = [f"{families} of generated maps, {each} each"] if len(maps) else []
    if study.families and places:
        places[0] += (
            f" of about {number(study.size)} states (band “{study.band}”), with"
            f" {_counted(study.seeds, 'life', 'lives')} on each map"
        )
    if study.article_maps:
        places.append(
            f"{_counted(len(study.article_maps), 'map')} of the article, with"
            f" {_counted(study.article_seeds, 'life', 'lives')}"
        )
    return (
        "A second study with the package, apart from the reproduction: methods, maps and numbers are not the article’s,"
        f" except where its maps are named. {_counted(int(lives['method'].nunique()), 'method')} on"
        f" {' and on '.join(places)}. A life is six tasks of {_counted(study.learning.episodes, 'episode')};"
        f" {_counted(len(lives), 'life', 'lives')} in all."
    )


def _counted(count: int, noun: str, nouns: str = "") -> str:
    return f"{number(count)} {noun if count == 1 else nouns or f'{noun}s'}"


def explorer_line(study: SecondStudy, looks: Mapping[str, Look]) -> str:
    """Describe the explorer; empty without one."""
    names = methods.by_identifier(map(our_methods.reference, study.explorer.methods))
    if not names:
        return ""
    return (
        f"one more life of {_listed(list(names), looks)} on each of {_counted(len(shown(study)), 'map')}, step by step."
    )


READING = (
    "How to read this. Cost is the number of steps over all tasks after the first, as a multiple of the optimum"
    " (episodes × shortest paths, or expected steps of the best policy where steps slip): 1 cannot be beaten."
    " Means are geometric, brackets are intervals. A method is called"
    " cheaper or dearer in a family if the whole interval of its ratio to PTL on the same maps lies on one side of 1."
    " The first number of a line is the geometric mean over the generated families, each counting alike. The lines are"
    " made from the numbers of this run."
)


def method_lines(study: SecondStudy) -> list[str]:
    """Describe design and statistics."""
    level, resamples = percent(study.statistics.confidence), number(study.statistics.resamples)
    return [
        f"Intervals ({level}) are percentiles of a hierarchical bootstrap with {resamples} resamples: maps, then lives"
        " on each map; all methods on the same maps. For a map of the article only lives are drawn, so its intervals"
        " say nothing about other maps. They are not corrected for the number of comparisons.",
        "Maps, their seeds and hashes are in studies/beyond/config/population.csv. What was tuned was tuned on the"
        " tuning band, which has no map in common with the test band; studies/beyond/README.md says what was tried.",
        "Every method is a file in ptl/methods/ or studies/beyond/methods/, with its source. Hyper-parameters are those"
        " of the reproduction, tuned for none of the methods.",
        "Limits: deterministic grid worlds, tables instead of function approximation, one start a map. A method that"
        " keeps a model of all transitions fits such worlds better than a robot’s; noise would cost it more than the"
        " others.",
        "Numbers of each life: per_life.csv. Truncated episodes are counted in it.",
    ]
