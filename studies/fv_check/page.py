"""The gains of policy reuse in Fernandez and Veloso's experiment under each reading, beside those of their figure."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import pandas as pd

from ptl.measures.statistics import Resampling, mean, named_generator
from ptl.report.table import Cell, Column, Row, RowGroup, Table
from ptl.text import MISSING, interval, number, percent
from studies.fv_check.experiment import MAX_STEPS, NEW_TASK, STREAM, PastTasks
from studies.fv_check.jobs import Gains
from studies.fv_check.readings import PUBLISHED, SHOWN, SUMMARIES, Reading, by_order
from studies.fv_check.simulator import MOTIONS, ORDERS, TIES

READ_OFF = 0.01
"""Error of a value read off the source's figure."""

CLASS, SIMULATOR = "class", "simulator"
"""What has learned: the class of the main comparison, or the simulator of this study."""

UNKNOWNS = {"motion": "the robot's motion", "ties": "the rule for ties", "summary": "what the figure plots"}
"""Facts on which the readings differ, by column."""

READING = list(UNKNOWNS)

NOTES = (
    f"Values of the source are read off its figure, each within about {READ_OFF}. A value is within a reading if it"
    f" lies in the interval widened by {READ_OFF} on either side; a reading is compatible if all three are.",
    "“This package's class” is the learner of the main comparison. It knows no noise, so the readings are learned by"
    " a second implementation, a simulator of this study.",
    "The class's library is learned in the same setting by plain Q-learning (ε-greedy, ε = 0.1) over {library_trials}"
    " trials, anew for every seed; the simulator's policies are optimal on the map without noise (our choices). The"
    " mean gain of past policies in their own tasks, as a share of the optimum without noise, is {learned} for the"
    " class, and for the simulator {optimal}.",
    "Where a past policy's values are all equal (never informed) the new policy acts (our choice). A start is drawn"
    " uniformly from all cells but the goal (our choice). Further choices stand in studies/fv_check/simulator.py.",
)
"""Choices, printed under the table."""


def gain_frame(gains: Iterable[Gains], readings: Iterable[Reading], how: Resampling) -> pd.DataFrame:
    """Compute the gain of every library under every reading.

    Columns learner, motion, ties, summary, library (name), runs, gain, ci_low, ci_high, order_low, order_high (least
    and greatest mean of an order, for ties "first_any" instead of an interval), std, published, within (whether the
    published value lies in the interval or `READ_OFF` beside it; missing without either), library_quality.
    """
    rows = []
    for item in gains:
        quality = item.quality.mean() if item.quality.size else np.nan
        rows.append(_row(CLASS, "exact", "random", "trials", item.library, item.gain.mean(axis=1), quality, how))
    for reading in readings:
        for summary, (_, summarise) in SUMMARIES.items():
            for index, library in enumerate(SHOWN):
                values, quality = summarise(reading, index), reading.quality.mean()
                rows.append(_row(SIMULATOR, reading.motion, reading.ties, summary, library, values, quality, how))
    return pd.DataFrame(rows).astype({"within": "boolean"})


def _row(
    learner: str,
    motion: str,
    ties: str,
    summary: str,
    library: PastTasks,
    values: np.ndarray,
    quality: float,
    how: Resampling,
) -> dict[str, object]:
    # different orders are different settings, so an interval of their mean would be one of nothing
    spread = ties == "first_any"
    estimate = mean(values, how, named_generator(STREAM, learner, motion, ties, summary, library.name))
    low, high = (np.nan, np.nan) if spread else (estimate.low, estimate.high)
    orders = by_order(values) if spread else np.array([np.nan])
    published = PUBLISHED.get(library.name, np.nan)
    return {
        "learner": learner,
        "motion": motion,
        "ties": ties,
        "summary": summary,
        "library": library.name,
        "runs": len(values),
        "gain": estimate.value,
        "ci_low": low,
        "ci_high": high,
        "order_low": orders.min(),
        "order_high": orders.max(),
        "std": values.std(ddof=1) if len(values) > 1 else np.nan,
        "published": published,
        "within": pd.NA if np.isnan(published + low) else low - READ_OFF <= published <= high + READ_OFF,
        "library_quality": quality,
    }


# -- what the numbers say -----------------------------------------------------------------------------------------


def compatible(frame: pd.DataFrame) -> list[tuple[str, ...]]:
    """Return motion, ties and summary of the readings that have all published values within."""
    within = _counted(frame).groupby(READING, sort=False)["within"]
    counts = within.sum()
    return [tuple(names) for names in counts.index[counts == len(SHOWN)]]


def ranges(frame: pd.DataFrame) -> pd.DataFrame:
    """Return by how much the gain moves with each unknown, all else equal: mean and maximum by unknown.

    A range is the greatest gain less the least one over the values of the unknown; there is one for each library and
    each combination of the other unknowns. Those of motion and ties are for the mean over all trials, which the source
    writes of.
    """
    counted, rows = _counted(frame), {}
    for unknown in UNKNOWNS:
        rest = [*(name for name in READING if name != unknown), "library"]
        part = counted if unknown == "summary" else counted[counted["summary"] == "trials"]
        gain = part.groupby(rest)["gain"]
        reach = gain.max() - gain.min()
        rows[unknown] = {"mean": reach.mean(), "maximum": reach.max()}
    return pd.DataFrame.from_dict(rows, orient="index").sort_values("mean", ascending=False)


def distances(frame: pd.DataFrame) -> pd.Series:
    """Return by how many standard errors the class and the simulator differ under their common reading, by library."""
    common = frame[(frame["motion"] == "exact") & (frame["ties"] == "random") & (frame["summary"] == "trials")]
    ours, theirs = (common[common["learner"] == name].set_index("library") for name in (CLASS, SIMULATOR))
    variance = theirs["std"] ** 2 / theirs["runs"] + ours["std"] ** 2 / ours["runs"]
    return ((ours["gain"] - theirs["gain"]) / np.sqrt(variance)).dropna()


def verdict(frame: pd.DataFrame) -> str:
    """Return which readings are compatible with the published values, and which facts decide."""
    counted = _counted(frame)
    number_of = len(counted.groupby(READING))
    if counted["within"].isna().any():
        return "There are too few runs for intervals, so no reading can be called compatible."
    found = compatible(frame)
    counts = counted.groupby(READING, sort=False)["within"].sum()
    if found:
        listed = "; ".join(_named(*names) for names in found)
        first = (
            f"{len(found)} of {number_of} readings {'is' if len(found) == 1 else 'are'} compatible with the"
            f" published values: {listed}. With {number_of} readings beside {len(SHOWN)} numbers read off a figure,"
            " that is no confirmation."
        )
    else:
        nearest = "; ".join(_named(*names) for names in counts.index[counts == counts.max()])
        first = f"None of {number_of} readings is compatible with all {len(SHOWN)} published values."
        if counts.max():
            first += f" The nearest have {counts.max()} of them within: {nearest}."
    moved = ranges(frame)
    parts = [
        f"{UNKNOWNS[name]} by {number(row['mean'], 3)} on average and {number(row['maximum'], 3)} at most"
        for name, row in moved.iterrows()
    ]
    most = counts.groupby("summary", sort=False).max()
    held = [f"{SUMMARIES[name][0]} {number_within}" for name, number_within in most.items()]
    return (
        f"{first} All else equal, a gain moves with {', with '.join(parts)}: {UNKNOWNS[moved.index[0]]} decides most."
        f" The greatest number of values within one reading is, by what the figure plots, {', '.join(held)}."
    )


def order_sentence(frame: pd.DataFrame) -> str:
    """Return how far the gains under fixed orders of the actions lie apart."""
    over = frame[(frame["ties"] == "first_any") & (frame["summary"] == "trials")]
    reach = (over["order_high"] - over["order_low"]).groupby(over["library"], sort=False).max()
    parts = [f"{number(reach[library.name], 2)} for {library.label}" for library in SHOWN]
    return (
        f"The order of the actions matters as well: over the {len(ORDERS['first_any'])} orders, with"
        f" {over['runs'].iloc[0]} runs in all, the gain moves by up to {', '.join(parts)}. East, north, south, west is"
        " one of the orders and was known to come near the published values, so a reading with it is fitted to them in"
        " part."
    )


def check_sentence(frame: pd.DataFrame) -> str:
    """Return how far the two implementations differ where both apply."""
    apart = distances(frame)
    if apart.empty:
        return "There are too few runs to compare the two implementations."
    listed = "; ".join(f"{item.label}: {abs(apart[item.name]):.1f}" for item in SHOWN if item.name in apart)
    return (
        "Without noise and with random ties the class and the simulator differ by this many standard errors of the"
        f" difference: {listed}. Their libraries are not the same."
    )


def _counted(frame: pd.DataFrame) -> pd.DataFrame:
    """Return the rows of readings proper: learned by the simulator, under one rule for ties."""
    return frame[(frame["learner"] == SIMULATOR) & (frame["ties"] != "first_any")]


def _named(motion: str, ties: str, summary: str) -> str:
    return f"{MOTIONS[motion].label}, of equal actions {TIES[ties]}, {SUMMARIES[summary][0]}"


# -- the table ----------------------------------------------------------------------------------------------------


def gain_table(frame: pd.DataFrame, trials: int, library_trials: int, confidence: float) -> Table:
    """Lay out the frame of `gain_frame`.

    Parameters
    ----------
    trials, library_trials : int
        Trials on the new task, and trials in which each policy of the class's library was learned.
    """
    learned = frame[frame["learner"] == CLASS]
    published = [Cell(number(value)) for value in PUBLISHED.values()]
    groups = [
        RowGroup([Row("read off the figure", [Cell(MISSING), *published, Cell(MISSING)])], "Published", "Published"),
        RowGroup([_table_row(learned)], "This package's class, no noise", "This package's class, no noise"),
    ]
    for motion, part in frame[frame["learner"] == SIMULATOR].groupby("motion", sort=False):
        label = f"Simulator, {MOTIONS[motion].label}"
        rows = [_table_row(own) for _, own in part.groupby(["ties", "summary"], sort=False)]
        groups.append(RowGroup(rows, label, label))
    plain = learned[learned["library"] == "q_learning"].iloc[0]
    notes = (
        verdict(frame),
        order_sentence(frame),
        f"Plain Q-learning (our method “no transfer”, ε = 0.1; the source's explores by other schedules) gains"
        f" {number(plain['gain'])} {interval(plain['ci_low'], plain['ci_high'])}.".replace(" .", "."),
        check_sentence(frame),
        *(text.format(library_trials=number(library_trials), **_qualities(frame)) for text in NOTES),
    )
    columns = [Column("gain", is_text=True), *(Column(library.label) for library in SHOWN), Column("values within")]
    runs = ", ".join(f"{part['runs'].iloc[0]} ({name})" for name, part in frame.groupby("learner", sort=False))
    intro = (
        f"Mean gain W of {number(trials)} trials on their task Ω (goal {NEW_TASK} of environment 3); random starts, at"
        f" most {MAX_STEPS} steps a trial. Below a gain is its {percent(confidence)} interval, or the range of the"
        f" means of all orders of the actions. Runs with each library: {runs}."
    )
    title = "Policy reuse in the experiment of Fernandez and Veloso"
    return Table(title, intro, "greedy action taken", columns, groups, notes, group_heading="robot")


def _table_row(part: pd.DataFrame) -> Row:
    by_library = part.set_index("library")
    first, rows = part.iloc[0], [by_library.loc[library.name] for library in SHOWN]
    cells = [Cell(number(row["gain"], 3), _detail(row)) for row in rows]
    known = [row["within"] for row in rows if not pd.isna(row["within"])]
    count = f"{sum(known)} of {len(rows)}" if known else MISSING
    return Row(TIES[first["ties"]], [Cell(SUMMARIES[first["summary"]][0]), *cells, Cell(count)])


def _detail(row: pd.Series) -> str:
    if np.isfinite(row["order_low"]):
        return f"{number(row['order_low'], 2)} to {number(row['order_high'], 2)}"
    return interval(row["ci_low"], row["ci_high"])


def _qualities(frame: pd.DataFrame) -> dict[str, str]:
    """Return the quality of the class's and of the simulator's libraries as texts."""
    learned = frame[frame["learner"] == CLASS]["library_quality"].mean()
    simulated = _counted(frame).drop_duplicates("motion")
    optimal = [f"{number(row.library_quality)} ({MOTIONS[row.motion].label})" for row in simulated.itertuples()]
    return {"learned": number(learned), "optimal": ", ".join(optimal)}
