"""Estimates of the second study, for each family of maps.

The cost of a life is its steps over the tasks after the first, as a multiple of the optimum (episodes x shortest
paths). Costs are averaged as logarithms, so that means are geometric and ratios of methods are symmetric. Choices
(ours; after Patterson et al., JMLR 25 (318), 2024, and Agarwal et al., NeurIPS 2021):

* A mean over families gives each the same weight.
* Every interval comes from `draw`: percentiles of a bootstrap that draws the maps of a family with replacement. The
  lives on a map enter by their mean, so that their variance is in that between maps. A family of one map (the
  article's) has its lives drawn, and its intervals do not generalise to other maps.
* Two methods are compared by the ratio of their costs on the same maps: a resample has the same maps for all methods
  of a family.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from scipy import stats

from ptl.errors import UserError
from ptl.measures.statistics import Estimate, Resampling, named_generator
from ptl.world.gridworld import GridWorld
from studies.beyond.design import ARTICLE
from studies.beyond.lives import NO_CHANGE
from studies.beyond.maps import MAIN
from studies.beyond.population import MapEntry

BASE = "ptl"
"""Method that others are compared with."""

NO_TRANSFER = "no_transfer"
"""Method that learns every task from nothing."""

SAVED = f"{BASE}/{NO_TRANSFER}"
"""Name of the cost of `BASE` as a multiple of that of `NO_TRANSFER` on the same map."""

ALL_MAPS, WITHIN = "all maps", "within families"
"""What a rank correlation is over."""

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


def draw(family: str, method: str, shape: tuple[int, ...], how: Resampling) -> np.ndarray:
    """Return what each resample is made of, int (resamples, units).

    Units are the maps of a family, the same ones for all methods, or the lives of a method if the family has one map.

    Parameters
    ----------
    shape : (maps, seeds)
    """
    maps, seeds = shape
    names, units = ((family, "maps"), maps) if maps > 1 else ((family, method, "lives"), seeds)
    return named_generator(*names).integers(units, size=(how.resamples, units))


def resample(values: np.ndarray, family: str, method: str, how: Resampling) -> np.ndarray:
    """Return resampled means, float (resamples, ...); NaN if there is a single unit.

    Parameters
    ----------
    values : float array, shape (maps, seeds, ...)
    """
    units = values.mean(axis=1) if len(values) > 1 else values[0]
    if len(units) == 1:
        return np.full((how.resamples, *units.shape[1:]), np.nan)
    return units[draw(family, method, values.shape[:2], how)].mean(axis=1)


def limits(drawn: np.ndarray, how: Resampling) -> tuple[np.ndarray, np.ndarray]:
    """Return the ends of the interval of resampled numbers, which are in the first axis."""
    tail = (1 - how.confidence) / 2
    low, high = np.quantile(drawn, [tail, 1 - tail], axis=0)
    return low, high


def _estimate(value: float, drawn: np.ndarray, how: Resampling) -> Estimate:
    return Estimate(float(value), *(float(end) for end in limits(drawn, how)))


def _geometric(log: float, drawn: np.ndarray, how: Resampling) -> Estimate:
    return _estimate(np.exp(log), np.exp(drawn), how)


@dataclass(frozen=True)
class Comparison:
    """The cost of a method as a multiple of that of another on the same maps, in each family and over families."""

    families: Mapping[str, Estimate]
    overall: Estimate

    @property
    def less(self) -> int:
        """Number of families in which the whole interval is below 1."""
        return sum(ratio.high < 1 for ratio in self.families.values())

    @property
    def more(self) -> int:
        """Number of families in which the whole interval is above 1."""
        return sum(ratio.low > 1 for ratio in self.families.values())


class Means:
    """Mean log(cost) of each method in each family, and its resamples.

    Parameters
    ----------
    lives : DataFrame
    how : Resampling
    """

    def __init__(self, lives: pd.DataFrame, how: Resampling) -> None:
        self.how = how
        self.logs = logarithms(lives)
        self._means = {names: float(values.mean()) for names, values in self.logs.items()}
        self._drawn = {names: resample(values, *names, how) for names, values in self.logs.items()}

    @property
    def families(self) -> list[str]:
        """All families."""
        return list(dict.fromkeys(family for family, _ in self.logs))

    def methods(self, families: Iterable[str]) -> list[str]:
        """Return the methods that were run in each of some families."""
        names = dict.fromkeys(method for _, method in self.logs)
        families = list(families)
        return [name for name in names if families and all((family, name) in self.logs for family in families)]

    def cost(self, families: Sequence[str], method: str) -> Estimate:
        """Return the geometric mean cost over families."""
        keys = [(family, method) for family in families]
        drawn = np.mean([self._drawn[key] for key in keys], axis=0)
        return _geometric(float(np.mean([self._means[key] for key in keys])), drawn, self.how)

    def ratio(self, families: Sequence[str], method: str, other: str) -> Estimate:
        """Return the geometric mean over families of the cost as a multiple of that of another method."""
        pairs = [((family, method), (family, other)) for family in families]
        mean = np.mean([self._means[own] - self._means[base] for own, base in pairs])
        drawn = np.mean([self._drawn[own] - self._drawn[base] for own, base in pairs], axis=0)
        return _geometric(float(mean), drawn, self.how)

    def compare(self, families: Sequence[str], method: str, other: str = BASE) -> Comparison:
        """Compare two methods in each of some families and over all of them."""
        by_family = {family: self.ratio([family], method, other) for family in families}
        return Comparison(by_family, self.ratio(families, method, other))


def costs(means: Means, lives: pd.DataFrame) -> pd.DataFrame:
    """Estimate the cost of each method in each family, and its ratio to the cost of `BASE` where that was run.

    Columns family, method, maps, seeds, cost, low, high, least (whether the ratio to the least cost of the family may
    be 1), ratio, ratio_low, ratio_high, improvement, improvement_low, improvement_high (probability that a life costs
    less than one of the base on the same map, ties half), library_size (mean at the end).
    """
    sizes = lives.groupby(["family", "method"])["library_size"].mean()
    rows = []
    for family in means.families:
        own = means.methods([family])
        cheapest = min(own, key=lambda method: means.cost([family], method).value)
        for method in own:
            values, cost = means.logs[family, method], means.cost([family], method)
            to_cheapest = means.ratio([family], method, cheapest)
            row = {"family": family, "method": method, "maps": values.shape[0], "seeds": values.shape[1],
                   "cost": cost.value, "low": cost.low, "high": cost.high,
                   "least": method == cheapest or to_cheapest.low <= 1}  # fmt: skip
            if BASE in own and method != BASE:
                ratio = means.ratio([family], method, BASE)
                better = improvement(values, means.logs[family, BASE], means.how, family, method)
                row |= {"ratio": ratio.value, "ratio_low": ratio.low, "ratio_high": ratio.high,
                        "improvement": better.value, "improvement_low": better.low,
                        "improvement_high": better.high}  # fmt: skip
            rows.append(row | {"library_size": sizes[family, method]})
    columns = ["family", "method", "maps", "seeds", "cost", "low", "high", "least", "ratio", "ratio_low", "ratio_high",
               "improvement", "improvement_low", "improvement_high", "library_size"]  # fmt: skip
    return pd.DataFrame(rows, columns=columns)


def improvement(values: np.ndarray, base: np.ndarray, how: Resampling, family: str, method: str) -> Estimate:
    """Return the probability that a life costs less than one of the base on the same map, ties counting half.

    Parameters
    ----------
    values, base : float arrays, shape (maps, seeds)
    """

    def share(own: np.ndarray, other: np.ndarray) -> np.ndarray:
        left, right = own[..., :, None], other[..., None, :]
        return ((left < right) + 0.5 * (left == right)).mean(axis=(-2, -1))

    shares = share(values, base)
    chosen = draw(family, method, values.shape, how)
    if len(values) > 1:
        drawn = shares[chosen].mean(axis=1)
    else:
        drawn = share(values[0][chosen], base[0][draw(family, BASE, base.shape, how)])
    return _estimate(shares.mean(), drawn, how)


def profiles(lives: pd.DataFrame, how: Resampling) -> pd.DataFrame:
    """Return performance profiles: the share of a family's lives with a cost of at most each threshold.

    Columns family, method, threshold, share, low, high.
    """
    parts = []
    for (family, method), values in logarithms(lives).items():
        within = (values[:, :, None] <= np.log(THRESHOLDS) + 1e-12).astype(float)
        low, high = limits(resample(within, family, method, how), how)
        parts.append(
            pd.DataFrame(
                {"family": family, "method": method, "threshold": THRESHOLDS, "share": within.mean(axis=(0, 1)),
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


def by_world(harder: pd.DataFrame, main: pd.DataFrame, how: Resampling) -> dict[str, tuple[Means, pd.DataFrame]]:
    """Return the means and the costs in each world: the certain one, then those that slip or change, on the same maps.

    Parameters
    ----------
    harder, main : DataFrame
        Lives in such worlds, and lives of the main comparison.

    Returns
    -------
    dict of (Means, DataFrame)
        The frame has the columns world, slip, change and those of `costs`; a cost is a multiple of the optimum of the
        same world.
    """
    keys = ["family", "map", "method", "seed"]
    same = main.merge(harder[keys].drop_duplicates(), on=keys).assign(slip=0.0, change=NO_CHANGE)
    worlds = {}
    for (slip, change), lives in pd.concat([same, harder]).groupby(["slip", "change"], sort=False):
        means = Means(lives, how)
        own = costs(means, lives).assign(slip=slip, change=change)
        own.insert(0, "world", world_name(slip, change))
        worlds[world_name(slip, change)] = (means, own)
    return worlds


# -- cost against other things -------------------------------------------------------------------------------


def _means(frame: pd.DataFrame, by: Sequence[str], how: Resampling) -> Iterator[dict[str, object]]:
    """Yield the geometric mean of ``cost`` in each group, with its interval."""
    for values, part in frame.groupby(list(by), sort=False):
        labels = dict(zip(by, values, strict=True))
        table = part.assign(log=np.log(part["cost"])).pivot(index="map", columns="seed", values="log").to_numpy()
        drawn = resample(table, str(labels["family"]), str(labels["method"]), how)
        estimate = _geometric(table.mean(), drawn, how)
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


def by_sequence(lives: pd.DataFrame, how: Resampling) -> dict[str, tuple[Means, pd.DataFrame]]:
    """Return the means and the costs under each sequence of tasks, on the maps that all sequences have."""
    own = lives[lives["sequence"] != ARTICLE]
    others = own[own["sequence"] != MAIN]
    keys = ["family", "map", "method"]
    same = own.merge(others[keys].drop_duplicates(), on=keys)
    sequences = {}
    for name, part in same.groupby("sequence", sort=False):
        means = Means(part, how)
        frame = costs(means, part)
        frame.insert(0, "sequence", name)
        sequences[str(name)] = (means, frame)
    return sequences


# -- cost against how hard a map is --------------------------------------------------------------------------


HARDNESS = ("diameter", "winding")
"""Measures of how hard a map is."""


def diameter(world: GridWorld) -> int:
    """Return the longest of the shortest paths between two states of a map, in steps."""
    return int(max(world.distances_to(state).max() for state in range(world.n_states)))


def hardness(lives: pd.DataFrame, entries: Iterable[MapEntry], methods: Iterable[str]) -> pd.DataFrame:
    """Return the geometric mean cost of some methods on each generated map, with the measures of the map.

    Columns family, map, diameter, winding, and one for each method that was run.
    """
    own = lives[lives["sequence"] == MAIN]
    own = own.assign(log=np.log((own["total_steps"] / own["optimum"]).astype(float)))
    logs = own.pivot_table(index=["family", "map", "size"], columns="method", values="log", sort=False)
    known = {(entry.family, str(entry.seed), entry.size): entry for entry in entries}
    shown = [method for method in methods if method in logs]
    rows = [
        {"family": place[0], "map": place[1], "diameter": diameter(known[place].world()),
         "winding": known[place].winding, **np.exp(logs.loc[place, shown])}
        for place in logs.index
        if place in known
    ]  # fmt: skip
    return pd.DataFrame(rows, columns=["family", "map", *HARDNESS, *shown])


def rank_correlation(groups: Iterable[tuple[np.ndarray, np.ndarray]]) -> np.ndarray:
    """Return Spearman's coefficient over the last axis, with ranks taken within each group; NaN if nothing varies.

    Parameters
    ----------
    groups : iterable of pairs of arrays (..., maps)
        Two measures of the maps of each group. The covariances and the variances of the ranks are added over groups.
    """
    sums = []
    for pair in groups:
        left, right = (
            ranks - ranks.mean(axis=-1, keepdims=True) for ranks in (stats.rankdata(own, axis=-1) for own in pair)
        )
        sums.append([(left * right).sum(axis=-1), (left**2).sum(axis=-1), (right**2).sum(axis=-1)])
    together, of_left, of_right = np.sum(sums, axis=0)
    scale = np.sqrt(of_left * of_right)
    return np.divide(together, scale, out=np.full(np.shape(scale), np.nan), where=scale > 0)


def hardness_trends(frame: pd.DataFrame, how: Resampling) -> pd.DataFrame:
    """Return the rank correlation of costs with each measure of hardness.

    Parameters
    ----------
    frame : DataFrame
        As `hardness` makes it.

    Returns
    -------
    DataFrame
        Columns cost (a method, or `SAVED`: the base's cost as a multiple of no transfer's), hardness, scope, value,
        low, high. The scope is `ALL_MAPS`, or `WITHIN`: ranks are taken within each family. In a resample the maps of
        each family are drawn.
    """
    quantities = {name: frame[name] for name in frame.columns[2 + len(HARDNESS) :]}
    if {BASE, NO_TRANSFER} <= set(quantities):
        quantities[SAVED] = frame[BASE] / frame[NO_TRANSFER]
    places = {str(family): own for family, own in frame.groupby("family", sort=False).indices.items() if len(own) > 2}
    drawn = [own[draw(family, "", (len(own), 1), how)] for family, own in places.items()]
    chosen = {
        ALL_MAPS: ([np.concatenate([*places.values()])], [np.concatenate(drawn, axis=-1)]),
        WITHIN: ([*places.values()], drawn),
    } if places else {}  # fmt: skip
    rows = []
    for (name, cost), measure, (scope, (all_maps, resampled)) in itertools.product(
        quantities.items(), HARDNESS, chosen.items()
    ):
        x, y = frame[measure].to_numpy(), cost.to_numpy()
        value, spread = (rank_correlation((x[own], y[own]) for own in groups) for groups in (all_maps, resampled))
        found = _estimate(float(value), spread, how)
        rows.append((name, measure, scope, found.value, found.low, found.high))
    return pd.DataFrame(rows, columns=["cost", "hardness", "scope", "value", "low", "high"])
