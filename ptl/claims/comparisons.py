"""The comparisons that make up claims.

Where the tables have the same number, the interval is the same too: same name, same random stream.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from ptl.claims.evidence import Evidence, MissingEvidence
from ptl.claims.reading import LAST_TASK, TRANSFER_TASKS, tasks_text
from ptl.claims.thresholds import FAR, MAJORITY
from ptl.claims.verdict import Part, above, below, not_significant
from ptl.measures import statistics
from ptl.measures.measures import BASE, BY_NAME, MEASURES
from ptl.measures.statistics import Estimate, named_generator
from ptl.text import percent

FULL, REUSE = "full_transfer", "policy_reuse"
PTL, SUPERVISED, UNKNOWN = "ptl", "ptl_supervised", "ptl_unknown_goal"
VARIANTS = (PTL, SUPERVISED, UNKNOWN)
OTHERS = (BASE, FULL, REUSE)

ARTICLE_MEASURES = ("jump_start", "asymptotic", "threshold_episode", "total_steps", "transfer_ratio")
"""The measures of the article's tables."""


def label(metric: str) -> str:
    """Return the name of a measure in a sentence."""
    return BY_NAME[metric].heading.lower()


def own_and_base(
    evidence: Evidence, environment: str, tasks: str, method: str, metric: str
) -> tuple[np.ndarray, np.ndarray]:
    """Return a measure of the method and of the base, two arrays (seeds,).

    The first episode of the base is what the jump start compares with: its expectation, where that is known.
    """
    if metric == "first_episode":
        own = evidence.values(environment, tasks, method, metric)
        return own, own + evidence.values(environment, tasks, method, "jump_start")
    return evidence.pair((environment, tasks, method), (environment, tasks, BASE), metric)


# -- estimates -----------------------------------------------------------------------------------------------


def mean(evidence: Evidence, environment: str, task: str, method: str, metric: str) -> Estimate:
    """Return the mean of a measure over seeds."""
    values = evidence.values(environment, task, method, metric)
    return statistics.mean(values, evidence.how, named_generator(environment, task, method, metric, "mean"))


def level(evidence: Evidence, environment: str, task: str, method: str, metric: str) -> float:
    """Return the mean of a measure over seeds, as the scale of a difference."""
    return float(evidence.values(environment, task, method, metric).mean())


def saved(evidence: Evidence, environment: str, task: str, method: str, other: str, metric: str) -> Estimate:
    """Return the mean of a measure of another method minus that of the method, paired by seed; positive is good."""
    own, others = evidence.pair((environment, task, method), (environment, task, other), metric)
    generator = named_generator(environment, task, method, other, metric, "saved")
    return statistics.mean_difference(others, own, evidence.how, generator)


def saved_percent(evidence: Evidence, environment: str, task: str, method: str, metric: str) -> Estimate:
    """Return the steps that a method saves of a measure, in % of the base (a ratio of means)."""
    own, base = own_and_base(evidence, environment, task, method, metric)
    [name] = [measure.name for measure in MEASURES if measure.saves == metric and measure.function is None]
    generator = named_generator(environment, task, method, name)
    return statistics.ratio_of_means(100.0 * (base - own), base, evidence.how, generator)


def reached(evidence: Evidence, environment: str, task: str, method: str) -> Estimate:
    """Return the share of the seeds that reach the threshold."""
    values = evidence.values(environment, task, method, "threshold_episode")
    return share(evidence, ~np.isnan(values))


def share(evidence: Evidence, hits: np.ndarray) -> Estimate:
    """Return the share of true values, one a run, with its Wilson interval."""
    return statistics.share(int(np.count_nonzero(hits)), len(hits), evidence.how)


def mean_share(evidence: Evidence, hits: np.ndarray, *names: str) -> Estimate:
    """Return the share of true values, (runs, cases); the interval resamples whole runs."""
    return statistics.mean(hits.mean(axis=1), evidence.how, named_generator(*names, "share"))


def difference_of_shares(evidence: Evidence, hits: np.ndarray, others: np.ndarray, *names: str) -> Estimate:
    """Return the difference of two shares of true values, both (runs, cases) of the same runs."""
    generator = named_generator(*names, "difference of shares")
    return statistics.mean_difference(hits.mean(axis=1), others.mean(axis=1), evidence.how, generator)


def probability_of_being_quicker(evidence: Evidence, environment: str, task: str, method: str, other: str) -> Estimate:
    """Return the probability that a run of the method reaches the threshold sooner; never reaching it comes last."""
    own, others = (
        np.nan_to_num(evidence.values(environment, task, name, "threshold_episode"), nan=np.inf)
        for name in (method, other)
    )
    names = [environment, task, method, "threshold_episode", "improvement"] + [other] * (other != BASE)
    return statistics.probability_of_improvement(own, others, "lower", evidence.how, named_generator(*names))


def episodes_to_threshold(evidence: Evidence, environment: str, tasks: str, method: str) -> np.ndarray:
    """Return the time to threshold of each seed, the mean over tasks; never reaching it counts as all episodes."""
    times = [
        np.nan_to_num(
            evidence.values(environment, task, method, "threshold_episode"),
            nan=float(evidence.length(environment, method, task)),
        )
        for task in tasks
    ]
    return np.mean(times, axis=0)


def mean_episodes(evidence: Evidence, environment: str, task: str, method: str) -> Estimate:
    """Return the mean of `episodes_to_threshold` (a restricted mean, as of survival times)."""
    generator = named_generator(environment, task, method, "episodes_to_threshold")
    return statistics.mean(episodes_to_threshold(evidence, environment, task, method), evidence.how, generator)


def times_as_many_episodes(evidence: Evidence, environment: str, tasks: str, method: str, other: str) -> Estimate:
    """Return the mean episodes to threshold of the other method over those of the method."""
    totals = []
    for task in tasks:
        pair = evidence.pair((environment, task, method), (environment, task, other), "threshold_episode")
        lengths = (float(evidence.length(environment, name, task)) for name in (method, other))
        totals.append([np.nan_to_num(times, nan=length) for times, length in zip(pair, lengths, strict=True)])
    own, others = np.sum(totals, axis=0)
    generator = named_generator(environment, tasks, method, other, "times_as_many_episodes")
    return statistics.ratio_of_means(others, own, evidence.how, generator)


def jump_start(evidence: Evidence, environment: str, tasks: str, method: str) -> Estimate:
    """Return the mean jump start, with the interval of as many runs as the reading of "not significant" has."""
    values = evidence.values(environment, tasks, method, "jump_start")
    if evidence.reading.runs is not None:
        return statistics.mean_of_fewer(values, evidence.reading.runs, evidence.how)
    return mean(evidence, environment, tasks, method, "jump_start")


# -- parts ---------------------------------------------------------------------------------------------------


def improves(evidence: Evidence, environment: str, tasks: str, method: str, measure: str) -> Part:
    """Return the part that claims that the method improves a measure over no transfer.

    Of several tasks, steps and episodes are added up seed by seed first; a seed that never reaches the threshold of one
    task comes last.
    """
    chosen = BY_NAME[measure]
    text = f"{tasks_text(tasks)}, {method}, {label(measure)}"
    if chosen.saves:
        in_steps = chosen.unit == "steps"
        scale = float(own_and_base(evidence, environment, tasks, method, chosen.saves)[1].mean()) if in_steps else 1.0
        estimate = mean(evidence, environment, tasks, method, measure)
        return above(text, estimate, 0.0, "steps" if in_steps else "", scale)
    if chosen.can_miss:
        estimate = probability_of_being_quicker(evidence, environment, tasks, method, BASE)
        return above(f"{text}, probability of being quicker", estimate, 0.5)
    estimate = saved(evidence, environment, tasks, method, BASE, measure)
    return above(f"{text}, saved", estimate, 0.0, "steps", level(evidence, environment, tasks, BASE, measure))


def saves(evidence: Evidence, environment: str, method: str, other: str, metric: str, tasks: str) -> Part:
    """Return the part that claims that the method needs fewer steps than another by a measure."""
    estimate = saved(evidence, environment, tasks, method, other, metric)
    scale = level(evidence, environment, tasks, other, metric)
    return above(f"{tasks_text(tasks)}, {label(metric)}, {other} minus {method}", estimate, 0.0, "steps", scale)


def needs_fewer_episodes(evidence: Evidence, environment: str, other: str, tasks: str) -> Iterator[Part]:
    """Yield the parts that claim that PTL reaches the threshold sooner than another method, in far fewer episodes."""
    quicker = probability_of_being_quicker(evidence, environment, tasks, PTL, other)
    yield above(f"{tasks_text(tasks)}, probability that {PTL} is quicker than {other}", quicker, 0.5)
    times = times_as_many_episodes(evidence, environment, tasks, PTL, other)
    yield above(f"{tasks_text(tasks)}, episodes of {other} over those of {PTL}", times, FAR, "times")


def jump_start_not_significant(evidence: Evidence, environment: str, tasks: str, method: str) -> Part:
    """Return the part that denies a significant jump start, by the runs of which the reading speaks."""
    text = f"{tasks_text(tasks)}, {method}, jump start"
    return not_significant(text, jump_start(evidence, environment, tasks, method), "steps")


def mostly(evidence: Evidence, text: str, hits: np.ndarray) -> Part:
    """Return the part that claims that most runs are hits."""
    return above(f"{text}, share of runs", share(evidence, hits), MAJORITY)


def fewer_than(evidence: Evidence, environment: str, method: str, bound: float, task: str) -> Part:
    """Return the part that claims that the method reaches the threshold within some episodes."""
    episodes = mean_episodes(evidence, environment, task, method)
    return below(f"task {task}, {method}, episodes to the threshold", episodes, bound, "episodes")


# -- notes ---------------------------------------------------------------------------------------------------


def elsewhere(
    evidence: Evidence, environment: str, metric: str, cases: Iterable[tuple[str, str]] | None = None
) -> Iterator[str]:
    """Note the steps that PTL saves on the other tasks, and its variants on the last one; gaps are left out."""
    cases = cases or [
        *((PTL, task) for task in TRANSFER_TASKS[:-1]),
        (SUPERVISED, LAST_TASK),
        (UNKNOWN, LAST_TASK),
    ]
    texts = []
    for method, task in cases:
        try:
            own, base = own_and_base(evidence, environment, task, method, metric)
        except MissingEvidence:
            continue
        texts.append(f"{method} on {task} {percent(round(1 - own.mean() / base.mean(), 2))}")
    if texts:
        yield f"{label(metric)} saved in % of the base elsewhere: {', '.join(texts)}"


def never_reached(evidence: Evidence, environment: str, methods: Iterable[str], task: str) -> Iterator[str]:
    """Note the number of seeds that never reach the threshold and so enter means with the length of the task."""
    texts = []
    for method in methods:
        missing = int(np.isnan(evidence.values(environment, task, method, "threshold_episode")).sum())
        if missing:
            texts.append(f"{method} {missing}")
    if texts:
        yield f"seeds that never reach the threshold, counted with all their episodes: {', '.join(texts)}"
