"""A made-up run on which every claim of the article comes true, for tests that change it and judge it."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pandas as pd
from projects import MAPS

from ptl.claims.evidence import Evidence, settings_of
from ptl.config import Learning
from ptl.learning.discoveries import SubgoalRow
from ptl.measures.measures import Runs, measure
from ptl.world.map_files import load_map

ENVIRONMENTS, TASKS = ("env1", "env2", "env3"), "ABCDEF"
BASE, FULL, REUSE = "no_transfer", "full_transfer", "policy_reuse"
PTL, SUPERVISED, UNKNOWN = VARIANTS = ("ptl", "ptl_supervised", "ptl_unknown_goal")
METHODS = (BASE, FULL, REUSE, *VARIANTS)
EPISODES, SEEDS = 200, 12
GROUPS = SimpleNamespace(
    learning=Learning(),
    measures=SimpleNamespace(window=10, threshold_factor=1.5),
    statistics=SimpleNamespace(confidence=0.95, resamples=200),
    growth=SimpleNamespace(breakpoint=7),
)


class MadeUpRun:
    """A run that agrees with the article's statements on every curve, subgoal and library.

    ``curves`` gives for each environment, method and task: steps of the first episode, steps of the episodes
    from the second to the last slow one, that one's number, steps at the end in shortest paths, and episodes
    that are spikes. ``peaks`` gives the peaks of both metrics, incremental and original, as cells.
    ``more_subgoals`` are rows added to the table of subgoals.
    """

    def __init__(self):
        self.worlds = {name: load_map(MAPS / f"{name}.txt") for name in ENVIRONMENTS}
        self.curves = {}
        for level, task in enumerate(TASKS, start=1):
            env1 = {
                BASE: [5000 * level, 2000 * level, 150, 1.3, ()],
                FULL: [9000 * level, 4000 * level, 150, 2.0, ()],
                REUSE: [6000 * level, 2500 * level, 150, 1.4, (170, 180)],
                PTL: [750 * level, 100 * level, 70, 1.1, ()],
                SUPERVISED: [700 * level, 90 * level, 70, 1.1, ()],
                UNKNOWN: [900 * level, 200 * level, 70, 1.1, ()],
            }
            env2 = {
                BASE: [3000, 800, 60, 1.3, ()],
                FULL: [1000, 300, 60, 1.2, ()],
                REUSE: [3000, 900, 60, 1.4, (100, 150)],
                PTL: [300, 100, 15, 1.1, ()],
                SUPERVISED: [300, 90, 15, 1.1, ()],
                UNKNOWN: [3000, 110, 15, 1.1, ()],
            }
            env3 = {
                BASE: [2000, 500, 40, 1.2, ()],
                FULL: [2000, 100, 5, 1.2, ()],
                REUSE: [2000, 100, 5, 1.2, (90, 150)],
                PTL: [2000, 100, 5, 1.1, ()],
                SUPERVISED: [2000, 100, 5, 1.1, ()],
                UNKNOWN: [2000, 100, 5, 1.1, ()],
            }
            for name, methods in zip(ENVIRONMENTS, (env1, env2, env3), strict=True):
                for method, curve in methods.items():
                    self.curves[name, method, task] = curve
        doors = [(6, 11 * level) for level in range(1, 7)]
        self.peaks = {
            "env1": ([(row, column - 1) for row, column in doors], [(6, 3)] * 6),
            "env2": ([(4, 2), (7, 7), (4, 12), (7, 17), (3, 25), (9, 27)], [(5, 9)] * 6),
            "env3": ([(6, 10), (5, 5), (14, 5), (15, 15), (2, 14), (2, 18)], [(5, 9)] * 6),
        }
        tasks = np.arange(31)
        self.library_sizes = np.minimum(tasks, 7) * 0.7 + np.maximum(tasks - 7, 0) * 0.1
        skills = np.array([1, 5, 10, 50, 100, 200, 400, 600, 800, 1000])
        self.selection = pd.DataFrame({"skills": skills, "operations": 5 + 30 * skills})
        self.more_subgoals = None
        self.selected = {"env1": self.at("env1", (6, 11), 60) + self.at("env1", (3, 4), 40)}
        self.library_bytes = pd.DataFrame({"states": 706, "skills": [1, 10], "bytes": [710, 7100]})

    def change(self, environment, methods, position, value, tasks=TASKS):
        for method in (methods,) if isinstance(methods, str) else methods:
            for task in tasks:
                curve = self.curves[environment, method, task]
                curve[position] = value(curve[position]) if callable(value) else value

    def swap(self, environment, one, others):
        """Give each of the others the curves of the one, and it those of the first of the others."""
        for task in TASKS:
            mine, theirs = (self.curves[environment, method, task] for method in (one, others[0]))
            for other in others:
                self.curves[environment, other, task] = list(mine)
            self.curves[environment, one, task] = theirs

    def evidence(self, seeds=SEEDS, methods=METHODS, environments=ENVIRONMENTS, groups=GROUPS):
        worlds = {name: self.worlds[name] for name in environments}
        runs = [self.runs(key, seeds) for key in self.curves if key[0] in environments and key[1] in methods]
        measured = measure(runs, worlds, groups.measures.window, groups.measures.threshold_factor)
        return Evidence(
            per_seed=measured.per_seed,
            worlds=worlds,
            steps=measured.steps,
            subgoals=pd.concat([measured.subgoals, self.more_subgoals], ignore_index=True),
            growth=np.array([np.floor(self.library_sizes + run / seeds).astype(int) for run in range(seeds)]),
            frequencies=self.selected,
            selection_cost=self.selection,
            library_bytes=self.library_bytes,
            **settings_of(groups),
        )

    def at(self, environment, cell, number):
        """Return a number at one cell, 0 elsewhere."""
        world = self.worlds[environment]
        return np.bincount([world.state_at(*cell)], [number], world.n_states).astype(int)

    def runs(self, key, seeds):
        found = None
        if key[1] == PTL:
            incremental, original = (
                self.worlds[key[0]].state_at(*cells[TASKS.index(key[2])]) for cells in self.peaks[key[0]]
            )
            values = (incremental, 9.0, 0.8, "added", incremental, original)
            found = {name: np.full(seeds, value) for name, value in zip(SubgoalRow._fields, values, strict=True)}
        return Runs(*key, np.arange(seeds), self.steps(key, seeds), np.zeros(seeds, dtype=int), found)

    def steps(self, key, seeds):
        first, middle, until, end, spikes = self.curves[key]
        world = self.worlds[key[0]]
        shortest = world.shortest_path_length(world.start, world.goal(key[2]))
        curve = np.full((seeds, EPISODES), end * shortest)
        curve[:, :until] = middle
        curve[:, 0] = first
        curve[:, list(spikes)] *= 40
        random = np.random.default_rng([ord(letter) for letter in "".join(key)])
        return np.rint(curve * random.uniform(0.98, 1.02, size=(seeds, 1))).astype(np.int64)
