"""Fernandez and Veloso's experiment: gains, the library's policies, the simulator, files, table and figure."""

from __future__ import annotations

from pathlib import Path

import msgspec
import numpy as np
import pandas as pd
import pytest
import yaml
from projects import ROOT, Project, errors_of

from ptl import methods
from ptl.config import Parameters
from ptl.errors import UserError
from ptl.files import store
from ptl.files.csv import read_csv
from ptl.measures.statistics import Resampling
from ptl.methods._base import BaseMethod
from ptl.report.table import to_html, to_markdown
from ptl.world.gridworld import GridWorld, map_digest
from ptl.world.map_files import load_map
from studies.fv_check import experiment as fv
from studies.fv_check import figure, page
from studies.fv_check import simulator as sim
from studies.fv_check.jobs import MAP, FvCheck, gains_of, jobs_of, readings_of
from studies.fv_check.readings import PUBLISHED, SHOWN, by_order

CORRIDOR = GridWorld.from_text("#####\n#I.F#\n#####\n")
ENV3 = load_map(ROOT / "config/environments/env3.txt")
ROOMS = GridWorld.from_text("#########\n#I..#...#\n#.......#\n#...#...#\n##.###.##\n#...#.F.#\n#########\n")
CONFIG = ROOT / "studies/fv_check/config/fv_check.yaml"


class Walker(BaseMethod):
    """Always goes east."""

    def run_episode(self, learner) -> list[int]:
        learner.follow(np.full(self.world.n_states, 3, dtype=np.int8), self.world.goal("F"))
        return []


# -- the experiment -----------------------------------------------------------------------------------------------


def test_gain_is_the_discounted_return_of_a_trial() -> None:
    starts = fv.random_starts(CORRIDOR, 2, 50, np.random.default_rng(0))
    assert set(starts) == {0, 1}, "never the goal itself"
    walker = Walker(CORRIDOR, fv.PARAMETERS, None)
    gains, learner = fv.learn_gains(CORRIDOR, 2, walker, fv.PARAMETERS, 40, ("a", 1), 3)
    assert set(np.round(gains, 12)) == {1.0, 0.95}, "one step and two steps from the goal"
    assert learner.q[1, 3] > 0


def test_a_trial_ends_after_a_hundred_steps_without_gain() -> None:
    class Stander(Walker):
        def run_episode(self, learner) -> list[int]:
            learner.follow(np.zeros(3, dtype=np.int8), 2)
            assert learner.truncated
            assert learner.steps == 100
            return []

    gains, _ = fv.learn_gains(CORRIDOR, 2, Stander(CORRIDOR, fv.PARAMETERS, None), fv.PARAMETERS, 3, ("b",), 3)
    assert not gains.any()


def test_quality_of_a_policy() -> None:
    goal = ENV3.goal("A")
    best = ENV3.transitions.shortest_path_policy(goal)
    undefined = np.full(ENV3.n_states, -1, dtype=np.int8)
    assert fv.policy_quality(ENV3, best, goal, fv.PARAMETERS) == pytest.approx(1.0)
    assert fv.policy_quality(ENV3, undefined, goal, fv.PARAMETERS) == 0.0
    assert fv.policy_quality(CORRIDOR, np.array([-1, 3, 0]), 2, fv.PARAMETERS) == pytest.approx(1 / 1.95)


def learned(tasks: str, seed: int, trials: int, library_trials: int) -> tuple[np.ndarray, np.ndarray]:
    return fv.learn_library(ENV3, tasks, fv.PARAMETERS, 1, seed, trials, library_trials)


def test_the_learner_is_that_of_the_main_comparison(monkeypatch: pytest.MonkeyPatch) -> None:
    reuse = methods.load("policy_reuse")
    sizes = []
    original = reuse.run_episode

    def spy(self, learner) -> list[int]:
        sizes.append(len(self.past_policies))
        return original(self, learner)

    monkeypatch.setattr(reuse, "run_episode", spy)
    gains, quality = learned("234", 0, 20, 50)
    assert sizes == [3] * 20
    assert (gains.shape, quality.shape) == ((20,), (3,))


def test_a_past_policy_does_not_depend_on_the_library_it_is_in() -> None:
    (_, three), (_, four), (_, other) = (learned(*values, 2, 400) for values in (("234", 4), ("1234", 4), ("234", 5)))
    assert three.tolist() == four[1:].tolist()
    assert three.tolist() != other.tolist()


def test_a_good_library_beats_plain_q_learning() -> None:
    """Task 5 is next to the new task, so its policy helps from the first hundred trials on (source: FV)."""
    good, plain = (np.mean([learned(tasks, seed, 800, 20_000)[0].mean() for seed in (0, 1)]) for tasks in ("2345", ""))
    assert good > 1.3 * plain


# -- the simulator ------------------------------------------------------------------------------------------------


class Fixed:
    """A source of one fixed noise."""

    def __init__(self, *noise: float) -> None:
        self.noise = np.array(noise)

    def random(self, shape) -> np.ndarray:
        return np.full(shape, 0.9)

    def uniform(self, low, high, shape) -> np.ndarray:
        assert (low, high) == (-0.2, 0.2)
        return np.broadcast_to(self.noise, shape)


def moved(text: str, motion: str, action: int, noise: tuple[float, float]) -> tuple[int, np.ndarray]:
    """Cell and position of a robot that has started near the south-eastern corner of cell 0."""
    world = GridWorld.from_text(text)
    robots = sim.Robots(world, sim.MOTIONS[motion], Fixed(*noise))
    robots.place(np.array([0]))
    robots.move(np.array([action]))
    return int(robots.states[0]), robots.positions[0] - sim.MARGIN


def test_a_move_is_one_cell_and_the_noise_of_both_axes() -> None:
    state, position = moved("I..\n..F\n", "noisy", 3, (0.05, -0.1))
    assert state == 1
    assert position == pytest.approx([0.95, 1.8])
    assert moved("I..\n..F\n", "noisy", 3, (0.2, 0.2))[0] == 5, "drifted into the row below, two cells on"


def test_a_blocked_move_leaves_the_position() -> None:
    for motion in ("noisy", "noisy_end"):
        state, position = moved("I#.\n..F\n", motion, 3, (0.0, 0.0))
        assert state == 0
        assert position == pytest.approx([0.9, 0.9])


def test_a_wall_along_the_move_counts_only_where_it_is_looked_for() -> None:
    """The robot enters the wall at (0, 1) before it drifts into row 1."""
    assert moved("I#.\n..F\n", "noisy", 3, (0.15, 0.0))[0] == 0
    assert moved("I#.\n..F\n", "noisy_end", 3, (0.15, 0.0))[0] == 3
    assert moved("I#F\n...\n", "noisy", 3, (0.0, 0.2))[0] == 0
    assert moved("I#F\n...\n", "noisy_end", 3, (0.0, 0.2))[0] == 1, "a long move jumps over a wall"


@pytest.mark.parametrize("motion", sim.MOTIONS)
def test_robots_stay_in_the_free_cells_that_they_observe(motion: str) -> None:
    random = np.random.default_rng(4)
    robots = sim.Robots(ENV3, sim.MOTIONS[motion], random)
    robots.place(np.arange(ENV3.n_states))
    for _ in range(50):
        before, actions = robots.states, random.integers(4, size=ENV3.n_states)
        robots.move(actions)
        cells = np.floor(robots.positions - sim.MARGIN).astype(int)
        assert (cells == ENV3.cells[robots.states]).all()
        if motion == "exact":
            assert (robots.states == ENV3.successors[before, actions]).all()


def test_equal_actions_are_ranked_by_the_orders() -> None:
    ranks, spread = sim.tie_ranks("first_ensw", 2)
    assert np.argsort(-ranks, axis=1).tolist() == [[3, 0, 1, 2]] * 2, "east, north, south, west"
    assert not spread.any()
    ranks, _ = sim.tie_ranks("first_any", 48)
    assert len({tuple(rank) for rank in ranks}) == 24
    assert ranks[:24].tolist() == ranks[24:].tolist()
    ranks, spread = sim.tie_ranks("random", 3)
    assert (ranks == 0).all()
    assert (spread == 1).all()


def test_the_first_of_equal_actions_is_taken() -> None:
    """East comes first and leads to the goal, so a robot that knows nothing takes one or two steps."""
    robots = sim.Robots(CORRIDOR, sim.MOTIONS["exact"], np.random.default_rng(1))
    none = np.empty((0, 3), dtype=np.int8)
    lanes = sim.learn(robots, 2, [none] * 5, *sim.tie_ranks("first_ensw", 5), fv.PARAMETERS, 20, robots._random)
    assert set(np.round(lanes.gain.ravel(), 12)) == {1.0, 0.95}
    assert lanes.arm_trials.tolist() == [[20]] * 5
    assert lanes.arm_gain[:, 0] == pytest.approx(lanes.gain.mean(axis=0))


def test_past_policies_are_optimal_and_break_ties_by_the_rule() -> None:
    random = np.random.default_rng(5)
    goal = ENV3.goal("A")
    robots = sim.Robots(ENV3, sim.MOTIONS["exact"], random)
    found = {ties: sim.optimal_policies(ENV3, [goal], *sim.tie_ranks(ties, 24), random)[:, 0] for ties in sim.TIES}
    for policies in found.values():
        assert sim.policy_quality(robots, goal, policies, fv.PARAMETERS) == pytest.approx(1.0)
        assert (policies[:, goal] == -1).all()
    assert len(np.unique(found["first_ensw"], axis=0)) == 1
    assert len(np.unique(found["random"], axis=0)) == 24
    first = ENV3.transitions.shortest_path_policy(goal)
    assert (found["first_any"][0] == first).all(), "the first order is that of the package"


@pytest.mark.parametrize("motion", ["noisy", "noisy_end"])
def test_no_policy_that_knows_the_noise_is_much_better(motion: str) -> None:
    """Value iteration on sampled moves gives a policy that gains at most 4 % more than shortest paths."""
    random = np.random.default_rng(6)
    robots, goal, draws = sim.Robots(ENV3, sim.MOTIONS[motion], random), ENV3.goal("A"), 200
    chance = np.zeros((4, ENV3.n_states, ENV3.n_states))
    states = np.repeat(np.arange(ENV3.n_states), draws)
    for action in range(4):
        robots.place(states)
        robots.move(np.full(len(states), action))
        np.add.at(chance[action], (states, robots.states), 1 / draws)
    value = np.zeros(ENV3.n_states)
    for _ in range(100):
        value[goal] = 1 / 0.95
        known = 0.95 * chance @ value
        value = known.max(axis=0)
    best = np.tile(known.argmax(axis=0).astype(np.int8), (5, 1))
    shortest = sim.optimal_policies(ENV3, [goal], *sim.tie_ranks("random", 5), random)[:, 0]
    gains = [
        np.mean([sim.policy_quality(robots, goal, policies, fv.PARAMETERS) for _ in range(10)])
        for policies in (best, shortest)
    ]
    assert 0.85 < gains[1] < gains[0] + 0.01
    assert gains[0] < 1.04 * gains[1]


def test_the_simulator_agrees_with_the_class() -> None:
    """Without noise, with random ties and one library, both means are those of one law (4 standard errors)."""
    runs, trials, goal = 150, 40, ROOMS.goal("F")
    parameters = Parameters.from_dict(
        {
            "learning": {"alpha": 0.3, "gamma": 0.95, "max_steps": 20},
            "policy_reuse": {"psi": 0.9, "psi_decay": 0.9, "temperature": 0.5, "temperature_step": 0.2},
        }
    )
    past = [ROOMS.transitions.shortest_path_policy(ROOMS.state_at(*cell)) for cell in ((5, 5), (1, 7))]
    past[1][ROOMS.state_at(2, 3)] = -1  # it says nothing there
    ours, uses = np.empty((runs, trials)), np.empty((runs, 3))
    for run in range(runs):
        method = methods.load("policy_reuse")(ROOMS, parameters, np.random.default_rng(run))
        method.past_policies = past
        ours[run], _ = fv.learn_gains(ROOMS, goal, method, parameters, trials, ("agreement", run), 1)
        uses[run] = method.selection.uses
    random = np.random.default_rng(7)
    robots = sim.Robots(ROOMS, sim.MOTIONS["exact"], random)
    libraries = [np.array(past)] * runs
    lanes = sim.learn(robots, goal, libraries, *sim.tie_ranks("random", runs), parameters, trials, random)
    theirs = lanes.gain.T
    pairs = [
        (ours.mean(axis=1), theirs.mean(axis=1)),
        (ours[:, :10].mean(axis=1), theirs[:, :10].mean(axis=1)),
        (ours[:, -10:].mean(axis=1), theirs[:, -10:].mean(axis=1)),
        *zip(uses.T, lanes.arm_trials.T, strict=True),
    ]
    for own, other in pairs:
        error = np.sqrt((own.var(ddof=1) + other.var(ddof=1)) / runs)
        assert abs(own.mean() - other.mean()) < 4 * error
    assert 0.2 < ours.mean() < 0.8, "there is something to compare"


# -- files, table and figure --------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def jobs() -> list:
    brief = {"seeds": 5, "trials": 20, "library_trials": 100, "reading_runs": 6}
    given = yaml.safe_load(CONFIG.read_text()) | brief
    return list(jobs_of(FvCheck.from_dict(given), map_digest(ENV3.text)).values())


@pytest.fixture(scope="module")
def results(jobs: list, tmp_path_factory: pytest.TempPathFactory) -> list[store.Result]:
    folder, worlds = tmp_path_factory.mktemp("results"), {MAP: ENV3}
    read = []
    for job in jobs:
        path = folder / Path(job.place).name
        store.write(path, job, job.run(worlds), worlds)
        read.append(store.read(path, job))
    return read


def test_a_result_of_another_job_is_refused(jobs: list, tmp_path: Path) -> None:
    job, worlds = msgspec.structs.replace(jobs[1], seeds=1, library_trials=5), {MAP: ENV3}
    store.write(tmp_path / "x.h5", job, job.run(worlds), worlds)
    with pytest.raises(UserError, match="library_trials 5, not 100"):
        store.read(tmp_path / "x.h5", msgspec.structs.replace(job, library_trials=100))
    with pytest.raises(UserError, match="its seeds are not 0, 1, 2"):
        store.write(tmp_path / "y.h5", job, job.run(worlds) | {"seeds": np.array([1])}, worlds)


def test_impossible_readings_are_refused(results: list[store.Result], tmp_path: Path) -> None:
    result = results[-1]
    wrong = result.arrays | {"arm_trials": result.arrays["arm_trials"] + 1}
    with pytest.raises(UserError, match="trials of the arms are not 20 in all"):
        store.write(tmp_path / "z.h5", result.job, wrong, {MAP: ENV3})


def test_readings_hold_the_gain_of_each_arm(results: list[store.Result]) -> None:
    readings = readings_of(results)
    assert [(reading.motion, reading.ties) for reading in readings] == [
        (motion, ties) for motion in sim.MOTIONS for ties in sim.TIES
    ]
    for reading in readings:
        weighted = (reading.arm_gain * reading.arm_trials).sum(axis=-1) / 20
        assert weighted == pytest.approx(reading.gain), "the mean over arms by their trials is that over trials"
        arms = 1 + len(SHOWN[0].tasks)
        assert not reading.arm_trials[0, :, arms:].any(), "the first library has no more arms"
        assert reading.over_arms(0) == pytest.approx(reading.arm_gain[0, :, :arms].mean(axis=-1))


def test_table_and_figure_say_what_the_files_say(results: list[store.Result]) -> None:
    gains, readings = gains_of(results), readings_of(results)
    frame = page.gain_frame(gains, readings, Resampling(0.95, 200))
    assert len(frame) == 4 + 9 * 2 * 3
    rows = frame.set_index(["learner", "motion", "ties", "summary", "library"])["gain"]
    for item in gains:
        assert rows[page.CLASS, "exact", "random", "trials", item.library.name] == pytest.approx(item.gain.mean())
    for reading in readings:
        for index, library in enumerate(SHOWN):
            key = page.SIMULATOR, reading.motion, reading.ties
            assert rows[(*key, "trials", library.name)] == pytest.approx(reading.gain[index].mean())
            assert rows[(*key, "arms", library.name)] == pytest.approx(reading.over_arms(index).mean())
    table = page.gain_table(frame, 20, 100, 0.95)
    for text in (to_markdown(table), to_html(table)):
        assert "walls along the move" in text
        assert "over 100 trials" in text
        assert page.verdict(frame) in text.replace("&#39;", "'")
    drawn = figure.draw(frame, 0.95)
    panels = drawn.axes
    assert [panel.get_title(loc="left").rpartition(" ")[2] for panel in panels] == ["0.07", "0.25", "0.275"]
    for panel, library in zip(panels, SHOWN, strict=True):
        shown = sorted(
            line.get_xdata()[0] for line in panel.lines if line.get_marker() in ("o", "s") and len(line.get_xdata())
        )
        assert shown == pytest.approx(sorted(frame[frame["library"] == library.name]["gain"]))


def test_means_by_order() -> None:
    assert by_order(np.arange(6.0)).tolist() == [0, 1, 2, 3, 4, 5]
    assert by_order(np.arange(48.0)).tolist() == [12.0 + order for order in range(24)]


def readings_frame(gains: dict[tuple[str, str, str], tuple[float, float, float]], half: float = 0.005) -> pd.DataFrame:
    """Frame of readings with these gains of the three libraries and intervals of this half width."""
    rows = []
    for names, values in gains.items():
        for (library, published), gain in zip(PUBLISHED.items(), values, strict=True):
            within = pd.NA if np.isnan(half) else abs(gain - published) <= half + page.READ_OFF
            row = dict(zip(page.READING, names, strict=True), library=library, gain=gain, within=within)
            rows.append(row | {"learner": page.SIMULATOR})
    return pd.DataFrame(rows).astype({"within": "boolean"})


def test_the_verdict_follows_from_the_numbers() -> None:
    gains = {
        ("exact", "random", "trials"): (0.21, 0.31, 0.32),
        ("exact", "first_ensw", "trials"): (0.075, 0.245, 0.262),
        ("noisy", "random", "trials"): (0.18, 0.25, 0.29),
        ("noisy", "first_ensw", "trials"): (0.08, 0.24, 0.2),
    }
    frame = readings_frame(gains)
    assert page.compatible(frame) == [("exact", "first_ensw", "trials")]
    text = page.verdict(frame)
    assert text.startswith(
        "1 of 4 readings is compatible with the published values: no noise, of equal actions the first of"
    )
    assert "confirmation" in text
    assert "the rule for ties decides most." in text
    assert text.endswith("mean over all trials 3.")
    moved = page.ranges(frame)
    assert moved.loc["ties", "maximum"] == pytest.approx(0.135)
    assert moved.loc["ties", "mean"] == pytest.approx(np.mean([0.135, 0.065, 0.058, 0.1, 0.01, 0.09]))
    assert moved.loc["motion", "maximum"] == pytest.approx(0.062)
    assert moved.loc["summary", "maximum"] == 0

    without = readings_frame({names: values for names, values in gains.items() if names[1] == "random"})
    assert page.verdict(without).startswith(
        "None of 2 readings is compatible with all 3 published values. The nearest have 2"
    )
    assert "too few runs" in page.verdict(readings_frame(gains, np.nan))


def test_an_interval_is_widened_by_the_error_of_reading_off(results: list[store.Result]) -> None:
    frame = page.gain_frame(gains_of(results), readings_of(results), Resampling(0.95, 200)).dropna(subset=["published"])
    reach = page.READ_OFF
    inside = (frame["ci_low"] - reach <= frame["published"]) & (frame["published"] <= frame["ci_high"] + reach)
    counted = frame["ties"] != "first_any"
    assert (frame["within"] == inside)[counted].all()
    assert frame["within"][~counted].isna().all(), "a mean over settings has no interval"


def test_the_page_of_the_study_tells_the_published_numbers() -> None:
    published = read_csv(ROOT / "reports/fv_check/table.csv")
    published["within"] = published["within"].astype("boolean")
    text = " ".join((ROOT / "studies/fv_check/README.md").read_text().split())
    ours = published[(published["learner"] == page.CLASS) & (published["library"] != "q_learning")]["gain"]
    assert f"{', '.join(f'{gain:.2f}' for gain in ours)} here; 0.07, 0.25, 0.275 there" in text
    assert f"{len(page.compatible(published)) or 'None'} of the 12 readings" in text
    assert f"{page.UNKNOWNS[page.ranges(published).index[0]]} moves the gains most".lower() in text.lower()
    assert (page.distances(published).abs() < 4).all(), "class and simulator agree where both apply"


# -- the workflow -------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_the_workflow_makes_remakes_and_refuses(tmp_path: Path) -> None:
    project = Project(tmp_path, None)
    project.add_study("fv_check")
    config = tmp_path / "studies/fv_check/config/fv_check.yaml"
    given = yaml.safe_load(config.read_text())
    brief = given | {"seeds": 2, "trials": 10, "library_trials": 20, "reading_runs": 2}
    config.write_text(yaml.safe_dump(brief))
    arguments = ("--snakefile", "studies/fv_check/Snakefile")
    project.make(*arguments)
    assert project.waiting(*arguments) == {}
    assert "are whole" in project.ptl("verify", "results/fv_check").stdout
    products = project.files("reports/fv_check")
    assert len(products) == 7
    (tmp_path / "reports/fv_check/table.csv").write_text("edited\n")
    assert "report_gains" in project.waiting(*arguments)
    config.write_text(yaml.safe_dump(brief | {"root_seed": 7}))
    waiting = project.waiting(*arguments)
    assert (waiting["learn_trials"], waiting["simulate_reading"]) == (4, 3)
    config.write_text(yaml.safe_dump(brief | {"trials": 0}))
    [line] = errors_of(project.snakemake("-n", *arguments))
    assert "trials" in line
    config.write_text(yaml.safe_dump(brief))
    project.make(*arguments)
    assert project.files("reports/fv_check") == products
