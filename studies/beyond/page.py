"""The page of the second study: answers that follow from the estimates, figures and tables."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from ptl import methods
from ptl.measures.statistics import Estimate, Resampling
from ptl.report.table import Cell, Column, Row, RowGroup, Table, text_table
from ptl.report.templating import render
from ptl.text import MISSING, estimate, interval, number, percent, place_of
from studies.beyond import methods as our_methods
from studies.beyond.design import SecondStudy
from studies.beyond.figures import Look
from studies.beyond.maps import MAIN
from studies.beyond.planned import shown
from studies.beyond.summary import ALL_MAPS, BASE, HARDNESS, NO_TRANSFER, SAVED, WITHIN, Comparison, Means

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

MEASURES = {"diameter": "diameter, steps", "winding": "winding (path ÷ straight line)"}
"""Label of each measure of hardness."""

HARD = (NO_TRANSFER, BASE, "rmax_memory")
"""Methods whose cost is compared with the hardness of maps."""

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
    "optimistic_fast": (NOTHING, "no, α is tuned to the slip", NOTHING),
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
            stated: tuple[str, str, str] = getattr(kind, "knows", Look.knows)
            looks[name] = Look(kind.label, kind.colour, dashed, KNOWLEDGE.get(name, stated))
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


def against_hardness(looks: Mapping[str, Look]) -> list[str]:
    """Return the methods whose cost is compared with hardness: those of `HARD`, and those of other people."""
    return [name for name in looks if name in HARD or name not in KNOWLEDGE] or list(looks)[: len(HARD)]


# -- sentences -----------------------------------------------------------------------------------------------

GLOSSARY: dict[str, tuple[str, tuple[str, ...]]] = {
    "PTL": (
        "partial transfer learning, the article’s method: Q-learning that begins an episode with a skill drawn from its"
        " library, or with none. A skill is a policy that leads to a subgoal, a state found in an earlier task by the"
        " article’s FD metric. “Lead-in”, “drawn again”, “mixed policy” are other readings of how a skill is used;"
        " “supervised” has the skill named by somebody who knows the map.",
        (BASE,),
    ),
    "No transfer": ("Q-learning that learns every task from nothing.", (NO_TRANSFER,)),
    "Full transfer, policy reuse, PLPR": (
        "action values, or whole policies, of earlier tasks instead of skills.",
        ("full_transfer", "policy_reuse", "policy_reuse_tuned", "plpr"),
    ),
    "Successor features": ("the best of the policies of all tasks at every state.", ("successor_features",)),
    "PTL, subgoal = …": (
        "PTL with subgoals from elsewhere: the task’s goal, a random visited state, the state farthest from the others,"
        " the end of the seen map by its graph’s second eigenvector (Fiedler), or the metric before the article’s.",
        FINDERS,
    ),
    "A skill to every state": ("PTL with the largest library that there can be.", ("all_goals",)),
    "Options": ("skills as further actions whose values are learned like those of steps.", OPTIONS),
    "Frontier": (
        "a skill to the edge of what has been seen, towards the goal (ours), with and without a library.",
        ("ptl_frontier", "ptl_frontier_path", "frontier_only"),
    ),
    "Path prior": ("PTL that counts steps where the article measures straight lines (ours).", ("ptl_path_prior",)),
    "Optimistic Q, MaxQInit": (
        "Q-learning that expects the best of what it has not tried; α is the learning rate, and MaxQInit starts from"
        " the greatest values of earlier tasks.",
        ("optimistic", "optimistic_fast", "maxqinit"),
    ),
    "R-max": (
        "a model of what was tried, a plan with it, and the nearest untried action first. An action counts as tried"
        " after m tries (once if no m is given); between tasks the model is kept or forgotten.",
        (*RMAX, "rmax_memory_5_stubborn", "rmax_directed"),
    ),
    "Plan in free space": (
        "shortest paths through all that has not proved to be a wall; walls are found by bumping into them, and kept or"
        " forgotten between tasks.",
        ("free_space", "free_space_memory"),
    ),
}
"""What names of methods mean, and the methods that they concern."""


def glossary(looks: Mapping[str, Look]) -> list[tuple[str, str]]:
    """Return the names that need a word, each with its meaning, for the methods shown."""
    return [(name, text) for name, (text, own) in GLOSSARY.items() if looks.keys() & set(own)]


MODEL, PLAN = "rmax_memory", "free_space_memory"
"""A remembered model, and a plan through cells that are taken for free until bumped into."""


def times(ratio: Estimate) -> str:
    """Format a ratio and its interval."""
    return estimate(ratio.value, ratio.low, ratio.high)


def sign(found: Estimate, null: float = 1.0) -> int:
    """Return -1 if a whole interval is below a value, 1 if it is above, 0 if it is not clear."""
    return int(found.low > null) - int(found.high < null)


def lead(means: Means, looks: Mapping[str, Look], families: Sequence[str]) -> str:
    """Answer the page's question from ratios on the same maps, over some families; the reader's own methods first."""
    names = means.methods(families)
    if BASE not in names or NO_TRANSFER not in names:
        return ""
    text = "".join(
        f"“{looks[name].label}” takes {times(means.ratio(families, name, BASE))} times PTL’s steps. "
        for name in names
        if name not in KNOWLEDGE
    )
    ratios = {name: means.ratio(families, name, BASE) for name in names if name != BASE}
    signs = [sign(ratio) for ratio in ratios.values()]
    text += (
        f"On the same maps PTL takes {times(means.ratio(families, BASE, NO_TRANSFER))} times as many steps as learning"
        f" every task from nothing. Of {len(ratios)} other methods, variants of it included, {signs.count(-1)} cost"
        f" less than PTL, {signs.count(1)} more, and {signs.count(0)} cannot be told from it."
    )
    better = [name for name in (MODEL, PLAN) if name in ratios and sign(ratios[name]) < 0]
    if better:
        listed = " and ".join(f"“{looks[name].label}” takes {times(ratios[name])}" for name in better)
        text += (
            " A robot that may keep what it has seen of the house needs no skills on maps of this size:"
            f" {listed} times PTL’s steps."
        )
    return text


def answers(means: Means, looks: Mapping[str, Look], families: Sequence[str]) -> list[dict[str, Any]]:
    """Return the questions, each with its answer; every statement follows from ratios on the same maps.

    Parameters
    ----------
    families : sequence of str
        Families of generated maps.
    """
    names = [name for name in looks if name in means.methods(families) and name != BASE]
    compared = {name: means.compare(families, name) for name in names} if BASE in means.methods(families) else {}
    return [
        {"question": "Is it better than strong rivals?", **_against(compared, looks)},
        {"question": "Which part of it does the work?", **_parts(compared, means, families, looks)},
        {
            "question": "Does it hold on maps that nobody chose?",
            "lead": _elsewhere(compared, means, families),
            "lines": [],
        },
    ]


def _verdicts(compared: Mapping[str, Comparison], names: Sequence[str], looks: Mapping[str, Look]) -> str:
    """Say which of some methods are cheaper than PTL in every family, more expensive in every family, or neither."""
    cheaper = [name for name in names if compared[name].less == len(compared[name].families)]
    dearer = [name for name in names if compared[name].more == len(compared[name].families)]
    rest = [name for name in names if name not in cheaper and name not in dearer]
    parts = [
        f"cheaper than PTL in every family: {_listed(cheaper, looks)}" if cheaper else "",
        f"dearer in every family: {_listed(dearer, looks)}" if dearer else "",
        f"not the same in every family, or not told from PTL: {_listed(rest, looks)}" if rest else "",
    ]
    return _sentence("; ".join(filter(None, parts)))


def _is_told_less(look: Look) -> bool:
    """Return whether a method relies on certain moves and is not told where the goal lies."""
    goal, moves, _ = look.knows
    return moves == CERTAIN and COORDINATES not in goal


def _against(compared: Mapping[str, Comparison], looks: Mapping[str, Look]) -> dict[str, Any]:
    names = [name for name in compared if name not in KNOWLEDGE]
    names += [name for name in (*RIVALS, *OPTIONS) if name in compared]
    lines = []
    certain = [name for name in names if _is_told_less(looks[name]) and compared[name].less]
    if certain:
        verb = "rely" if len(certain) > 1 else "relies"
        lines.append(
            f"To be fair to PTL: {_listed(certain, looks)} {verb} on moves that are certain, and a kept model needs a"
            " memory of every transition, which the article’s robot may not have. To be fair to them: PTL is told where"
            " the goal lies; these methods are not, though a kept model knows a goal that it has seen."
        )
    return {"lead": _verdicts(compared, names, looks), "lines": lines}


def _parts(
    compared: Mapping[str, Comparison], means: Means, families: Sequence[str], looks: Mapping[str, Look]
) -> dict[str, Any]:
    finders = [name for name in (*FINDERS, "all_goals") if name in compared]
    listed = "; ".join(f"“{looks[name].label}” {times(compared[name].overall)}" for name in finders)
    lead = f"PTL with other subgoals, as a multiple of PTL’s cost: {listed}." if finders else ""
    lines = []
    readings = [name for name in READINGS if name in compared]
    if readings:
        listed = "; ".join(f"“{looks[name].label}” {times(compared[name].overall)}" for name in readings)
        lines.append(f"PTL that uses the same skills otherwise: {listed}.")
    if "ptl_frontier" in compared and "frontier_only" in compared:
        library = means.compare(families, "ptl_frontier", "frontier_only")
        meaning = {
            -1: "the library helps it.",
            0: "the library makes no difference that these maps can show.",
            1: "the library makes it dearer. What it saves is owed to the memory of transitions and the goal’s"
            " direction.",
        }
        lines.append(
            "Our skill to the frontier costs, with the library, as a multiple of the same skill without it:"
            f" {times(library.overall)} (less in {library.less}, more in {library.more} of {len(library.families)}"
            f" families); {meaning[sign(library.overall)]}"
        )
    return {"lead": lead, "lines": lines}


def _elsewhere(compared: Mapping[str, Comparison], means: Means, families: Sequence[str]) -> str:
    if NO_TRANSFER not in compared:
        return ""
    comparison = means.compare(families, BASE, NO_TRANSFER)
    text = (
        f"PTL costs less than learning every task from nothing in {comparison.less} of {len(families)} families of"
        f" generated maps, more in {comparison.more}"
    )
    article = [
        f"{times(means.ratio([family], BASE, NO_TRANSFER))} on the article’s {family}"
        for family in means.families
        if family not in families and {BASE, NO_TRANSFER} <= set(means.methods([family]))
    ]
    values = [ratio.value for ratio in comparison.families.values()]
    spread = f"; by family it takes {number(min(values))} to {number(max(values))} times as many steps"
    return f"{'; '.join([text + spread, ', '.join(article)]) if article else text + spread}."


def harder_answer(worlds: Mapping[str, Means], looks: Mapping[str, Look], families: Sequence[str]) -> dict[str, Any]:
    """Return the question about worlds that slip or change, with its answer over some families.

    Parameters
    ----------
    worlds : mapping of Means
        From the name of a world; the certain one is among them.
    """
    common = set.intersection(*(set(means.methods(families)) for means in worlds.values()))
    names = [name for name in looks if name in common and name != BASE] if BASE in common else []
    signs = {
        name: {world: sign(means.ratio(families, name, BASE)) for world, means in worlds.items()} for name in names
    }
    cheaper, dearer = ([name for name in names if set(signs[name].values()) == {wanted}] for wanted in (-1, 1))
    parts = [
        f"cheaper than PTL in all {len(worlds)} worlds: {_listed(cheaper, looks)}" if cheaper else "",
        f"dearer in all: {_listed(dearer, looks)}" if dearer else "",
    ]
    lines = []
    for name in (name for name in names if name not in cheaper and name not in dearer):
        said = {
            "cheaper than PTL": [world for world in worlds if signs[name][world] < 0],
            "dearer": [world for world in worlds if signs[name][world] > 0],
            "not told from it": [world for world in worlds if signs[name][world] == 0],
        }
        listed = "; ".join(f"{verdict}: {', '.join(own)}" for verdict, own in said.items() if own)
        lines.append(f"“{looks[name].label}”: {listed}.")
    turned = [name for name in names if {-1, 1} <= set(signs[name].values())]
    text = _sentence("; ".join(filter(None, parts)))
    if names:
        text += f" It turns for {_listed(turned, looks)}." if turned else " No comparison with PTL turns."
    return {"question": "Does it turn where moves slip or the house changes?", "lead": text.strip(), "lines": lines}


def hardness_answer(trends: pd.DataFrame, looks: Mapping[str, Look]) -> dict[str, Any]:
    """Return the question about hard maps, with its answer.

    Parameters
    ----------
    trends : DataFrame
        As `studies.beyond.summary.hardness_trends` makes it.
    """
    found = {(row.cost, row.hardness, row.scope): Estimate(row.value, row.low, row.high) for row in trends.itertuples()}
    parts = []
    for measure in HARDNESS:
        saved = {scope: found[key] for scope in (ALL_MAPS, WITHIN) if (key := (SAVED, measure, scope)) in found}
        listed = ", ".join(
            f"{correlation(value)} {SCOPES[scope]} ({TRENDS[sign(value, 0.0)]})" for scope, value in saved.items()
        )
        parts.append(f"with the {measure} {listed}" if listed else "")
    lead = "; ".join(filter(None, parts))
    if lead:
        lead = f"What PTL takes as a multiple of no transfer’s steps has the rank correlation {lead}."
    lines = [
        f"Of the cost of “{looks[name].label}”, over all maps: "
        + ", ".join(f"{measure} {correlation(found[name, measure, ALL_MAPS])}" for measure in HARDNESS)
        + "."
        for name in dict.fromkeys(trends["cost"])
        if name in looks
    ]
    return {"question": "Is it worth more on harder maps?", "lead": lead, "lines": lines}


TRENDS = {-1: "PTL saves more on harder maps", 0: "no trend", 1: "PTL saves less on harder maps"}
SCOPES = {ALL_MAPS: "over all maps", WITHIN: "within families"}


def correlation(found: Estimate) -> str:
    """Format a correlation and its interval with two decimals."""
    ends = f" [{number(found.low, 2)}, {number(found.high, 2)}]" if np.isfinite(found.low) else ""
    return f"{number(found.value, 2)}{ends}"


def _sentence(text: str) -> str:
    return f"{text[0].upper()}{text[1:]}." if text else ""


def _listed(names: Sequence[str], looks: Mapping[str, Look]) -> str:
    return ", ".join(f"“{looks[name].label}”" for name in names)


# -- tables --------------------------------------------------------------------------------------------------


NOTE = "Brackets: intervals."
BOLD = "Bold: the least of the column, and what cannot be told from it on the same maps."
EVERY = "every"
"""Name of the column, or group, of all families of generated maps, each counting alike."""


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
    best: str = "",
) -> Table:
    """Lay out a value of each method in columns; ``best`` names the column of the frame that says what is bold."""
    rows = []
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
            ends = [float(row[limit]) for limit in limits] if limits else [np.nan, np.nan]
            cells.append(
                Cell(number(float(row[value]), place_of(*ends)), interval(*ends), best=bool(best and row[best]))
            )
        rows.append(Row(look.label, cells, look.colour))
    return Table(title, intro, "method", [Column(heading) for heading in columns.values()], [RowGroup(rows)], notes)


def overall_ratios(means: Means, families: Sequence[str]) -> pd.DataFrame:
    """Return the ratios to `BASE` over some families.

    Columns family (`EVERY`), method, ratio, ratio_low, ratio_high.
    """
    names = means.methods(families)
    rows = []
    for name in names if BASE in names else []:
        if name != BASE:
            ratio = means.ratio(families, name, BASE)
            rows.append((EVERY, name, ratio.value, ratio.low, ratio.high))
    return pd.DataFrame(rows, columns=["family", "method", "ratio", "ratio_low", "ratio_high"])


def by_group_table(
    parts: Mapping[str, tuple[Means, pd.DataFrame]],
    looks: Mapping[str, Look],
    titles: Mapping[str, str],
    families: Sequence[str],
    title: str,
    intro: str,
) -> Table:
    """Lay out ratios to `BASE`, a column for each part, a group of rows for all families and for each.

    Parameters
    ----------
    parts : mapping of (Means, DataFrame)
        As `studies.beyond.summary.by_world` makes them.
    """
    headings = {name: f"{name[0].upper()}{name[1:]}" for name in parts}
    frames = [
        pd.concat([overall_ratios(means, families), costs]).assign(part=name) for name, (means, costs) in parts.items()
    ]
    frame = pd.concat(frames) if frames else pd.DataFrame(columns=["family", "method", "part", "ratio"])
    groups = []
    for family, heading in {EVERY: "All families of generated maps", **titles}.items():
        own = frame[frame["family"] == family]
        made = wide_table(own, looks, headings, "part", "ratio", ("ratio_low", "ratio_high"), "", "")
        if made.groups[0].rows:
            groups.append(RowGroup(made.groups[0].rows, heading, family))
    columns = [Column(heading) for heading in headings.values()]
    return Table(title, intro, "method", columns, groups, (NOTE,), group_heading="family")


def trends_table(trends: pd.DataFrame, looks: Mapping[str, Look]) -> Table:
    """Lay out rank correlations of costs and hardness."""
    rows = []
    for cost, own in trends.groupby("cost", sort=False):
        cells = [
            Cell(number(row.value, 2), f"[{number(row.low, 2)}, {number(row.high, 2)}]" if np.isfinite(row.low) else "")
            for row in own.itertuples()
        ]
        look = looks.get(str(cost))
        rows.append(Row(look.label if look else "PTL ÷ no transfer", cells, look.colour if look else ""))
    first = trends.drop_duplicates(["hardness", "scope"])
    return Table(
        "Rank correlation of cost and hardness",
        "Spearman’s coefficient over all maps, and with ranks taken within each family.",
        "cost of",
        [Column(str(row.hardness).capitalize(), str(row.scope)) for row in first.itertuples()],
        [RowGroup(rows)],
        (NOTE,),
    )


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
    )


# -- the page ------------------------------------------------------------------------------------------------


def page(**values: Any) -> str:
    """Fill the page's template."""
    return render("beyond.html", folder=TEMPLATES, title="Is a skill library worth having, and where?", **values)


def introduction(study: SecondStudy, lives: pd.DataFrame) -> str:
    """Describe the runs, and say what a life and its cost are."""
    own = lives[lives["sequence"] == MAIN]
    maps = own.groupby("family")["map"].nunique()
    places = []
    if len(maps):
        kinds = _counted(len(maps), "kind (family)", "kinds (families)")
        places.append(f"{kinds} of generated maps ({_counted(int(maps.min()), 'map')} each")
        places[0] += f", of about {number(study.size)} states" if study.families else ""
        places[0] += f", {_counted(study.seeds, 'life', 'lives')} on each map)"
    if study.article_maps:
        places.append(
            f"{_counted(len(study.article_maps), 'map')} of the article"
            f" ({_counted(study.article_seeds, 'life', 'lives')} on each)"
        )
    return (
        "The article’s robot learns one task after another in a house, and keeps a library of skills (partial transfer"
        f" learning, PTL). Here PTL and {number(int(lives['method'].nunique()) - 1)} other methods live on"
        f" {' and on '.join(places)}. A life is six tasks of {number(study.learning.episodes)} episodes;"
        f" {number(len(lives))} lives in all. The cost of a life is its number of steps over the tasks after the first,"
        " as a multiple of the fewest that are possible (the optimum). None of this is a claim of the article."
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
    "A method is called cheaper or dearer than another if the whole interval of the ratio of their costs on the same"
    " maps lies on one side of 1; otherwise they cannot be told apart. Bars and bands beside a cost are of one method"
    " by itself and do not say whether two methods differ. The sentences are made from the numbers of this run."
)

ANOTHER_HOUSE = (
    "A kept model, or a plan in free space, is worth nothing in a house that it has not seen; a skill that says what to"
    " do at a doorway might be worth something there. That is the case for a skill library, and this page does not test"
    " it. What it tests makes memory easy: one house of a few hundred places, which the robot can tell apart without"
    " error and count one by one, and tasks that differ in their goal only. Where a memory of all that is allowed, the"
    " answers above say whether a library adds anything. Not tried here: skills that cross from one map to another,"
    " houses too large to remember place by place, a state that is seen in part or with errors, and function"
    " approximation in place of tables. Nothing here says who would win there. A fair test would give the rivals the"
    " same senses: a fixed rule that sees walls nearby and the goal’s direction may do what a learned skill does."
)
"""What no library is needed for here, and what was not tried."""


def statistics_line(how: Resampling) -> str:
    """State the one rule of all intervals."""
    return (
        f"Every interval on this page is the {percent(how.confidence)} percentile interval of {number(how.resamples)}"
        " bootstrap resamples of the maps of each family, the same maps for all methods (of the lives, on a single map"
        " of the article, where it says nothing about other maps), not corrected for the number of comparisons."
    )


def method_lines(study: SecondStudy, how: Resampling) -> list[str]:
    """Describe design and statistics."""
    lines = [
        statistics_line(how),
        "Means over maps, lives and families are geometric; families count alike.",
        "Maps, their seeds and hashes are in studies/beyond/config/population.csv. What was tuned (optimistic Q, policy"
        " reuse) was tuned on maps that are not shown here; all other hyper-parameters are those of the reproduction,"
        " which were chosen for PTL. studies/beyond/README.md says what was tried.",
        "Every method is a file in ptl/methods/ or studies/beyond/methods/, with its source.",
        "Numbers of each life: per_life.csv. Truncated episodes are counted in it.",
    ]
    if study.is_harder:
        lines.insert(
            2,
            f"Worlds that slip or change are on {number(study.harder.maps)} maps of each family; an interval of so few"
            " maps is little more than their range, and too narrow as a rule.",
        )
    return lines
