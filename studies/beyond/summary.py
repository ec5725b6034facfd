"""Estimates of the second study, for each family of maps.

The cost of a life is its steps over the tasks after the first, as a multiple of the optimum (episodes x shortest
paths). Costs are averaged as logarithms, so that means are geometric and ratios of methods are symmetric. Choices
(ours; after Patterson et al., JMLR 25 (318), 2024, and Agarwal et al., NeurIPS 2021):

* Nothing is pooled over families, except where noted; then families have equal weight.
* Intervals are percentiles of a hierarchical bootstrap: maps are drawn with replacement, then lives on each map. A
  family of one map (the article's) has its lives drawn only, and its intervals do not generalise to other maps.
* Methods are compared on the same maps: the maps drawn are the same for all methods of a family.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from scipy import stats

from ptl.errors import UserError
from ptl.measures.statistics import Estimate, Resampling, named_generator
from studies.beyond.design import ARTICLE
from studies.beyond.lives import NO_CHANGE
from studies.beyond.maps import MAIN
from studies.beyond.population import MapEntry

BASE = "ptl"
"""Method that others are compared with."""

THRESHOLDS = np.round(np.geomspace(1, 200, 70), 4)
"""Multiples of the optimum at which performance profiles are computed."""


def logarithms(lives: pd.DataFrame) -> dict[tuple[str, str], np.ndarray]:
    """Return log(cost) by family and method, float (maps, seeds); maps of a family in the same order for all methods.

    Raises
    ------
    UserError
        When methods of a family were not run on the same maps, or maps not by the same number of lives.
    """
    by_method: dict[tuple[str, str], np.ndarray] = {}
    for family, part in lives.groupby("family", sort=False):
        part = part.assign(log=np.log(part["total_steps"] / part["optimum"]))
        maps = sorted(part["map"].unique())
        for method, own in part.groupby("method", sort=False):
            table = own.pivot(index="map", columns="seed", values="log")
            if sorted(table.index) != maps or table.isna().any(axis=None):
                raise UserError(
                    f"method {method}: its lives in the family {family} are not those of the other methods; run it on"
                    " the same maps with the same number of seeds"
                )
            by_method[str(family), str(method)] = table.loc[maps].to_numpy()
    return by_method


def main_lives(lives: pd.DataFrame) -> pd.DataFrame:
    """Return the lives of the main comparison: tasks in increasing order, or as in the article."""
    return lives[lives["sequence"].isin([MAIN, ARTICLE])]


# -- the bootstrap -------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Drawn:
    """Resampled means of a family's logarithms by method, float (resamples,), from the same maps for all methods."""

    means: dict[str, np.ndarray]


def resample(logs: dict[str, np.ndarray], family: str, how: Resampling) -> Drawn:
    """Draw maps, then lives on each map.

    Parameters
    ----------
    logs : dict of arrays (maps, seeds), by method
    """
    maps = len(next(iter(logs.values())))
    chosen = named_generator(family, "maps").integers(maps, size=(how.resamples, maps))
    means = {}
    for method, values in logs.items():
        seeds = values.shape[1]
        lives = named_generator(family, method, "lives").integers(seeds, size=(how.resamples, maps, seeds))
        means[method] = values[chosen[:, :, None], lives].mean(axis=(1, 2))
    return Drawn(means)


def _geometric(values: np.ndarray, drawn: np.ndarray, how: Resampling) -> Estimate:
    tail = (1 - how.confidence) / 2
    low, high = np.exp(np.quantile(drawn, [tail, 1 - tail])) if values.size > 1 else (np.nan, np.nan)
    return Estimate(float(np.exp(values.mean())), float(low), float(high))


def costs(lives: pd.DataFrame, how: Resampling) -> pd.DataFrame:
    """Estimate the cost of each method in each family, and its ratio to the cost of `BASE` where that was run.

    Columns family, method, maps, seeds, cost, low, high, ratio, ratio_low, ratio_high, improvement, improvement_low,
    improvement_high (probability that a life costs less than one of the base on the same map, ties half), library_size
    (mean at the end).
    """
    logs = logarithms(lives)
    sizes = lives.groupby(["family", "method"])["library_size"].mean()
    rows = []
    for family in dict.fromkeys(family for family, _ in logs):
        own = {method: values for (name, method), values in logs.items() if name == family}
        drawn = resample(own, family, how).means
        for method, values in own.items():
            cost = _geometric(values, drawn[method], how)
            row = {"family": family, "method": method, "maps": values.shape[0], "seeds": values.shape[1],
                   "cost": cost.value, "low": cost.low, "high": cost.high}  # fmt: skip
            if BASE in own and method != BASE:
                difference = values.mean(axis=1) - own[BASE].mean(axis=1)
                ratio = _geometric(difference, drawn[method] - drawn[BASE], how)
                if values.shape[0] == 1:  # one map: the estimate has one difference, the interval all lives
                    ratio = _geometric(values - own[BASE].mean(), drawn[method] - drawn[BASE], how)
                better = improvement(values, own[BASE], how, family, method)
                row |= {"ratio": ratio.value, "ratio_low": ratio.low, "ratio_high": ratio.high,
                        "improvement": better.value, "improvement_low": better.low,
                        "improvement_high": better.high}  # fmt: skip
            rows.append(row | {"library_size": sizes[family, method]})
    columns = ["family", "method", "maps", "seeds", "cost", "low", "high", "ratio", "ratio_low", "ratio_high",
               "improvement", "improvement_low", "improvement_high", "library_size"]  # fmt: skip
    return pd.DataFrame(rows, columns=columns)


def improvement(values: np.ndarray, base: np.ndarray, how: Resampling, *names: str) -> Estimate:
    """Return the probability that a life costs less than one of the base on the same map, ties counting half.

    Parameters
    ----------
    values, base : float arrays, shape (maps, seeds)
    """

    def share(own: np.ndarray, other: np.ndarray) -> np.ndarray:
        left, right = own[..., :, None], other[..., None, :]
        return ((left < right) + 0.5 * (left == right)).mean(axis=(-2, -1))

    maps = len(values)
    random = named_generator(*names, "improvement")
    if maps > 1:  # all pairs of lives on a map belong to it
        drawn = share(values, base)[random.integers(maps, size=(how.resamples, maps))].mean(axis=1)
    else:
        own = values[0][random.integers(values.shape[1], size=(how.resamples, values.shape[1]))]
        other = base[0][random.integers(base.shape[1], size=(how.resamples, base.shape[1]))]
        drawn = np.array([share(a, b) for a, b in zip(own, other, strict=True)])
    tail = (1 - how.confidence) / 2
    low, high = np.quantile(drawn, [tail, 1 - tail])
    return Estimate(float(share(values, base).mean()), float(low), float(high))


def profiles(lives: pd.DataFrame, how: Resampling) -> pd.DataFrame:
    """Return performance profiles: the share of a family's lives with a cost of at most each threshold.

    Columns family, method, threshold, share, low, high; intervals from maps drawn with replacement (lives if there is
    one map).
    """
    parts = []
    tail = (1 - how.confidence) / 2
    for (family, method), values in logarithms(lives).items():
        units = values if len(values) > 1 else values.T
        within = (units[:, :, None] <= np.log(THRESHOLDS) + 1e-12).mean(axis=1)
        number = len(units)
        weights = named_generator(family, method, "profile").multinomial(
            number, np.full(number, 1 / number), how.resamples
        )
        low, high = np.quantile(weights @ within / number, [tail, 1 - tail], axis=0)
        parts.append(
            pd.DataFrame(
                {"family": family, "method": method, "threshold": THRESHOLDS, "share": within.mean(axis=0),
                 "low": low, "high": high}
            )
        )  # fmt: skip
    return pd.concat(parts, ignore_index=True)


def variance_components(lives: pd.DataFrame) -> pd.DataFrame:
    """Split the variance of log(cost / cost of `BASE`) into that between maps and that between lives on a map.

    One-way random effects, estimated by analysis of variance; lives of the two methods are paired by their number.
    Columns family, method, between_maps, between_lives (variances), intraclass (share of the first), error (standard
    error of the family's mean log ratio as run), error_fewer_maps (had the same lives been spent on a tenth of the
    maps).
    """
    rows = []
    logs = logarithms(lives)
    for (family, method), values in logs.items():
        maps, seeds = values.shape
        if method == BASE or (family, BASE) not in logs or maps < 2 or seeds < 2:
            continue
        ratio = values - logs[family, BASE]
        within = ratio.var(axis=1, ddof=1).mean()
        between = max(0.0, ratio.mean(axis=1).var(ddof=1) - within / seeds)
        total = between + within
        rows.append(
            {"family": family, "method": method, "between_maps": between, "between_lives": within,
             "intraclass": between / total if total else np.nan,
             "error": np.sqrt(between / maps + within / (maps * seeds)),
             "error_fewer_maps": np.sqrt(10 * between / maps + within / (maps * seeds))}
        )  # fmt: skip
    return pd.DataFrame(
        rows,
        columns=["family", "method", "between_maps", "between_lives", "intraclass", "error", "error_fewer_maps"],
    )


# -- worlds that slip or change ----------------------------------------------------------------------------


CERTAIN_WORLD = "certain"
"""Name of the world in which nothing slips and nothing changes."""


def world_name(slip: float, change: str) -> str:
    """Return the name of a world for readers."""
    if change != NO_CHANGE:
        return f"{change} change" if change == "cells" else f"a {change} changes"
    return f"slip {slip:g}" if slip else CERTAIN_WORLD


def harder_costs(harder: pd.DataFrame, main: pd.DataFrame, how: Resampling) -> pd.DataFrame:
    """Return the costs in each world that slips or changes, and in the certain one on the same maps.

    Parameters
    ----------
    harder, main : DataFrame
        Lives in such worlds, and lives of the main comparison.

    Returns
    -------
    DataFrame
        Columns world, slip, change and those of `costs`; a cost is a multiple of the optimum of the same world.
    """
    keys = ["family", "map", "method", "seed"]
    same = main.merge(harder[keys].drop_duplicates(), on=keys).assign(slip=0.0, change=NO_CHANGE)
    parts = []
    for (slip, change), lives in pd.concat([same, harder]).groupby(["slip", "change"], sort=False):
        own = costs(lives, how)
        own.insert(0, "world", world_name(slip, change))
        parts.append(own.assign(slip=slip, change=change))
    return pd.concat(parts, ignore_index=True)


# -- cost against other things -------------------------------------------------------------------------------


def _means(frame: pd.DataFrame, by: Sequence[str], how: Resampling) -> Iterator[dict[str, object]]:
    """Yield the geometric mean of ``cost`` in each group, with its hierarchical interval."""
    for values, part in frame.groupby(list(by), sort=False):
        labels = dict(zip(by, values, strict=True))
        table = part.assign(log=np.log(part["cost"])).pivot(index="map", columns="seed", values="log").to_numpy()
        drawn = resample({str(labels["method"]): table}, str(labels["family"]), how).means[str(labels["method"])]
        estimate = _geometric(table, drawn, how)
        yield labels | {"maps": len(table), "cost": estimate.value, "low": estimate.low, "high": estimate.high}


def by_task(tasks: pd.DataFrame, sequence: str, how: Resampling) -> pd.DataFrame:
    """Return the cost of each task in its place of the life: columns family, method, task, maps, cost, low, high.

    ``sequence`` names the sequence on generated maps; on the article's maps tasks come in their own order.
    """
    own = tasks[(tasks["per_task"] == 0) & tasks["sequence"].isin([sequence, ARTICLE])]
    own = own.assign(cost=(own["steps"] / own["optimum"]).astype(float))
    rows = list(_means(own, ("family", "method", "task"), how))
    return pd.DataFrame(rows, columns=["family", "method", "task", "maps", "cost", "low", "high"])


def by_library_size(tasks: pd.DataFrame, how: Resampling) -> pd.DataFrame:
    """Return the cost of libraries of given sizes.

    Columns family, method, per_task, maps, cost, low, high, library_size: mean number of skills in the library
    at the beginning of the tasks after the first, to which the cost refers.
    """
    own = tasks[tasks["sequence"].isin([MAIN, ARTICLE])]
    sized = own[own["per_task"] > 0]
    if sized.empty:
        return pd.DataFrame(columns=["family", "method", "per_task", "maps", "cost", "low", "high", "library_size"])
    # the methods as they are, on the same maps
    places = set(zip(sized["family"], sized["map"], strict=True))
    same = own[[place in places for place in zip(own["family"], own["map"], strict=True)]]
    keys = ["family", "method", "per_task", "map", "seed"]
    later = same[same["task"] > 1].groupby(keys, sort=False)[["steps", "optimum"]].sum()
    held = same[same["task"] < same["task"].max()].groupby(keys, sort=False)["library_size"].mean()
    lives = later.assign(cost=later["steps"] / later["optimum"], library_size=held).reset_index()
    frame = pd.DataFrame(_means(lives, ("family", "method", "per_task"), how))
    return frame.merge(lives.groupby(["family", "method", "per_task"], as_index=False)["library_size"].mean())


def by_sequence(lives: pd.DataFrame, how: Resampling) -> pd.DataFrame:
    """Return the cost under each sequence of tasks, on the maps that all sequences have.

    Columns family, method, sequence, maps, cost, low, high.
    """
    own = lives[lives["sequence"] != ARTICLE]
    others = own[own["sequence"] != MAIN]
    if others.empty:
        return pd.DataFrame(columns=["family", "method", "sequence", "maps", "cost", "low", "high"])
    keys = ["family", "map", "method"]
    same = own.merge(others[keys].drop_duplicates(), on=keys)
    same = same.assign(cost=same["total_steps"] / same["optimum"])
    return pd.DataFrame(_means(same, ("family", "method", "sequence"), how))


def by_winding(lives: pd.DataFrame, entries: Iterable[MapEntry]) -> pd.DataFrame:
    """Return the geometric mean cost on each generated map, with the winding of the map.

    Columns family, map, method, winding, cost.
    """
    windings = {(entry.family, str(entry.seed), entry.size): entry.winding for entry in entries}
    own = lives[lives["sequence"] == MAIN]
    own = own.assign(
        log=np.log(own["total_steps"] / own["optimum"]),
        winding=[windings.get(place, np.nan) for place in zip(own["family"], own["map"], own["size"], strict=True)],
    ).dropna(subset=["winding"])
    frame = own.groupby(["family", "map", "method"], sort=False, as_index=False).agg(
        winding=("winding", "first"), cost=("log", "mean")
    )
    return frame.assign(cost=np.exp(frame["cost"].astype(float)))


def winding_trends(frame: pd.DataFrame) -> pd.DataFrame:
    """Return Spearman's coefficient of cost and winding over the maps of each family.

    Columns family, method, coefficient, p.
    """
    rows = []
    for (family, method), part in frame.groupby(["family", "method"], sort=False):
        if len(part) > 4 and part["winding"].nunique() > 1 and part["cost"].nunique() > 1:
            correlation = stats.spearmanr(part["winding"], part["cost"])
            rows.append((family, method, correlation.statistic, correlation.pvalue))
    return pd.DataFrame(rows, columns=["family", "method", "coefficient", "p"])
