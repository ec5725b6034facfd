"""Every figure is made from small inputs: files, their bytes, numbers against the inputs, refusals."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from pathlib import Path

import h5py
import matplotlib as mpl
import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner

from ptl import methods
from ptl.archive import write_arrays
from ptl.commands.figure import command
from ptl.errors import UserError
from ptl.figures import cells, style
from ptl.figures.bands import mean_band
from ptl.figures.curves import METHODS
from ptl.figures.growth import TwoSlopes, fit_two_slopes, growth_frame
from ptl.figures.measures import trailing_mean
from ptl.frequencies import subgoal_frequencies
from ptl.gridworld import GridWorld
from ptl.learning import learn_life, tasks_of
from ptl.parameters import Learning, Parameters
from ptl.selection import prior
from ptl.store import open_learning, write_frequencies, write_learning

MAP = """\
#########
#I..#..A#
#.......#
#...#..B#
##.######
#......C#
#########
"""
PARAMETERS = Parameters.from_dict({"learning": {"episodes": 30}, "subgoals": {"trajectories": 10}})
SEEDS, RUNS = 3, 4
TWO_SLOPES = TwoSlopes(bend=7, intercept=0.5, before=0.6, after=0.2)


@pytest.fixture(scope="module", autouse=True)
def coarse_pictures() -> Iterator[None]:
    """Fewer dots than the published figures have, because painting dots takes time."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(style, "PNG_RESOLUTION", 60)
        yield


@pytest.fixture(scope="module")
def inputs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with one small input of every kind, real runs wherever runs are drawn."""
    folder = tmp_path_factory.mktemp("figures")
    (folder / "small.txt").write_text(MAP)
    world = GridWorld.from_text(MAP)
    for seed in range(SEEDS):
        life = learn_life(world, tasks_of(world, "ABC"), "ptl", PARAMETERS, 1, "small", seed)
        origin = {
            "environment": "small", "method": "ptl", "seed": seed, "root_seed": 1, "code": "-",
            "parameters": PARAMETERS.to_dict(),
        }  # fmt: skip
        write_learning(folder / f"seed_{seed}.h5", life, world, origin)
    arrays = subgoal_frequencies(world, range(3), 5, Learning(), 1, "small")
    origin = {
        "environment": "small", "trajectories": 5, "root_seed": 1, "code": "-",
        "parameters": PARAMETERS.to_dict(),
    }  # fmt: skip
    write_frequencies(folder / "frequencies.h5", arrays, world, origin)
    random = np.random.default_rng(0)
    steps = {
        f"small/{method}/C": random.poisson(np.geomspace(400 / (index + 1), 9, 60), size=(SEEDS, 60)) + 9
        for index, method in enumerate(METHODS)
    }
    write_arrays(folder / "steps.h5", "ptl-steps/1", steps, {})
    tasks = np.arange(13)
    pd.DataFrame(
        {
            "run": np.repeat(np.arange(RUNS), len(tasks)),
            "tasks": np.tile(tasks, RUNS),
            "library_size": np.concatenate([TWO_SLOPES(tasks) + run for run in range(RUNS)]),
        }
    ).to_csv(folder / "growth.csv", index=False)
    skills = np.array([1, 10, 100])
    pd.DataFrame({"skills": skills, "seconds": 3e-5 + 1e-7 * skills}).to_csv(folder / "selection.csv", index=False)
    storage = [(states, count, states * count) for states in (20, 50) for count in skills]
    pd.DataFrame(storage, columns=["states", "skills", "bytes"]).to_csv(folder / "storage.csv", index=False)
    return folder


ARGUMENTS: dict[str, Callable[[Path], list[str]]] = {
    "map": lambda at: [f"{at}/small.txt"],
    "prior": lambda at: [f"{at}/small.txt", "--goal", "C"],
    "misleading-prior": lambda at: [f"{at}/seed_{seed}.h5" for seed in range(SEEDS)],
    "frequencies": lambda at: [f"{at}/frequencies.h5", "--title", "small=Small"],
    "discovery": lambda at: [f"{at}/seed_0.h5", f"{at}/seed_1.h5", f"{at}/seed_2.h5", "--tasks", "BC"],
    "curves": lambda at: [f"{at}/steps.h5", "--map", f"small={at}/small.txt"],
    "measures": lambda at: [f"{at}/steps.h5", "--map", f"small={at}/small.txt"],
    "growth": lambda at: [f"{at}/growth.csv"],
    "library-cost": lambda at: [f"{at}/selection.csv", f"{at}/storage.csv"],
}
"""Arguments of every kind of figure."""


def run(kind: str, inputs: Path, output: Path, *more: str) -> None:
    """Call ``ptl figure``; errors come out as they are."""
    arguments = [kind, *ARGUMENTS[kind](inputs), "--output", str(output), *more]
    result = CliRunner().invoke(command, arguments, catch_exceptions=False)
    assert result.exit_code == 0, result.output


@pytest.fixture(scope="module")
def frames(inputs: Path) -> dict[str, pd.DataFrame]:
    """The CSV twin of every figure, by kind."""
    for kind in ARGUMENTS:
        run(kind, inputs, inputs / "out" / f"{kind}.png")
    return {
        kind: pd.read_csv(inputs / "out" / f"{kind}.csv", keep_default_na=False, na_values=[""]) for kind in ARGUMENTS
    }


def test_every_subcommand_is_tested() -> None:
    assert set(command.commands) == set(ARGUMENTS)


@pytest.mark.parametrize("kind", ARGUMENTS)
def test_same_inputs_give_the_same_bytes_whatever_the_settings(
    kind: str, inputs: Path, frames: dict[str, pd.DataFrame], tmp_path: Path
) -> None:
    with mpl.rc_context({"font.size": 30, "svg.hashsalt": None, "axes.grid": False, "savefig.bbox": "tight"}):
        run(kind, inputs, tmp_path / f"{kind}.png")
    for suffix in (".png", ".svg", ".csv"):
        again = (tmp_path / f"{kind}{suffix}").read_bytes()
        assert again == (inputs / "out" / f"{kind}{suffix}").read_bytes()
    assert b"<dc:date>" not in (tmp_path / f"{kind}.svg").read_bytes()


@pytest.mark.parametrize("kind", ARGUMENTS)
def test_picture_has_ink_and_nothing_is_cut_off(kind: str, inputs: Path, frames: dict[str, pd.DataFrame]) -> None:
    from matplotlib.image import imread

    paper = imread(inputs / "out" / f"{kind}.png")[..., :3].min(axis=2) > 0.99
    assert 0.01 < (~paper).mean() < 0.9
    # a margin of 2 dots all around stays white: labels that are cut off would cross it
    for edge in (paper[:2], paper[-2:], paper[:, :2], paper[:, -2:]):
        assert edge.all()


# -- numbers ------------------------------------------------------------------------------------------------


def test_map_numbers(frames: dict[str, pd.DataFrame]) -> None:
    world, frame = GridWorld.from_text(MAP), frames["map"]
    assert frame["letter"].tolist() == ["I", "A", "B", "C"]
    assert frame["state"].tolist() == [world.start, *world.goals.values()]
    assert frame["shortest_path"].tolist() == [
        world.shortest_path_length(world.start, state) for state in frame["state"]
    ]


def test_prior_numbers(frames: dict[str, pd.DataFrame]) -> None:
    world, frame = GridWorld.from_text(MAP), frames["prior"]
    distance = np.hypot(*(world.cells - world.cells[world.goal("C")]).T)
    np.testing.assert_allclose(frame["relative_prior"], np.exp(-distance / (0.1 * world.diagonal)), rtol=1e-5)


def test_misleading_prior_numbers(inputs: Path, frames: dict[str, pd.DataFrame]) -> None:
    frame = frames["misleading-prior"]
    np.testing.assert_allclose(frame.groupby("episode")["probability"].sum(), 1, rtol=1e-4)
    # the beginning is the prior
    expected: dict[str, list[float]] = {}
    for seed in range(SEEDS):
        with open_learning(inputs / f"seed_{seed}.h5") as file:
            world, task = file.world, file.tasks["C"]
            known = [skill for skill in file.library or [] if skill.learned_after < 2]
            names = ["none", *("ABC"[skill.learned_after] for skill in known)]
            states = [task.start, *(skill.subgoal for skill in known)]
            for name, chance in zip(names, prior(world.cells, states, task.goal, world.diagonal), strict=True):
                expected.setdefault(name, []).append(chance)
    first = frame[frame["episode"] == 1].set_index("skill")["probability"]
    assert set(first.index) == set(expected)
    assert len(expected) > 1
    for name, chances in expected.items():
        assert first[name] == pytest.approx(sum(chances) / SEEDS, rel=1e-5)


def test_misleading_prior_probabilities_are_those_the_learner_drew_from(
    inputs: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from ptl.figures import misleading_prior
    from ptl.methods.ptl import Method

    drawn: list[np.ndarray] = []
    original = Method.run_episode

    def watched(self: Method, learner: object) -> list[int]:
        drawn.append(self.selection.probabilities())
        return original(self, learner)

    monkeypatch.setattr(Method, "run_episode", watched)
    world = GridWorld.from_text(MAP)
    learn_life(world, tasks_of(world, "ABC"), "ptl", PARAMETERS, 1, "small", 0)
    frame = misleading_prior.collect([inputs / "seed_0.h5"], "C").frame
    names = list(dict.fromkeys(frame["skill"]))
    table = frame.pivot_table(index="episode", columns="skill", values="probability")
    candidates = ["none", *(name for name in names if name != "none")]
    np.testing.assert_allclose(table[candidates], np.array(drawn[-30:]), rtol=1e-12)


def test_frequency_numbers(inputs: Path, frames: dict[str, pd.DataFrame]) -> None:
    frame = frames["frequencies"]
    with h5py.File(inputs / "frequencies.h5") as file:
        assert frame["count"].tolist() == file["counts"][()].tolist()
        assert frame["count"].sum() + file["unresolved"][()] == file["pairs"][()]
        np.testing.assert_allclose(frame["share"], 100 * file["counts"][()] / file["pairs"][()], rtol=1e-5)


def test_discovery_numbers(inputs: Path, frames: dict[str, pd.DataFrame]) -> None:
    for (task, metric), part in frames["discovery"].groupby(["task", "metric"]):
        values, chosen = [], np.zeros(len(part), dtype=int)
        for seed in range(SEEDS):
            with open_learning(inputs / f"seed_{seed}.h5") as file:
                view = file.tasks[task]
                values.append(getattr(view, metric))
                choice = view.subgoal if metric == "incremental" else int(view.original.argmax())
                if choice >= 0:
                    chosen[choice] += 1
        np.testing.assert_allclose(part["value"], np.mean(values, axis=0), rtol=1e-5)
        assert part["chosen"].tolist() == chosen.tolist()
    assert set(frames["discovery"]["task"]) == {"B", "C"}


def test_curve_numbers(inputs: Path, frames: dict[str, pd.DataFrame]) -> None:
    with h5py.File(inputs / "steps.h5") as file:
        for method, part in frames["curves"].groupby("method"):
            np.testing.assert_allclose(part["mean"], file[f"small/{method}/C"][()].mean(axis=0), rtol=1e-5)
            assert (part["ci_low"] <= part["mean"] * 1.00001).all()
            assert (part["ci_high"] >= part["mean"] * 0.99999).all()
    assert set(frames["curves"]["method"]) == set(METHODS)


def test_measure_numbers(inputs: Path, frames: dict[str, pd.DataFrame]) -> None:
    world = GridWorld.from_text(MAP)
    with h5py.File(inputs / "steps.h5") as file:
        base, mine = (file[f"small/{method}/C"][()] for method in ("no_transfer", "ptl"))
    row = frames["measures"].query("method == 'ptl'").iloc[-1]
    assert row["jump_start"] == pytest.approx((base[:, 0] - mine[:, 0]).mean(), rel=1e-5)
    assert row["asymptotic"] == pytest.approx(mine[:, -10:].mean(), rel=1e-5)
    assert row["threshold"] == pytest.approx(1.5 * world.shortest_path_length(world.start, world.goal("C")))
    means = [mine[:, end - 10 : end].mean() for end in range(10, 61)]
    reached = [end for end, mean in enumerate(means, start=10) if mean <= row["threshold"]]
    assert row["threshold_episode"] == reached[0] if reached else np.isnan(row["threshold_episode"])


def test_growth_numbers(frames: dict[str, pd.DataFrame]) -> None:
    frame = frames["growth"]
    np.testing.assert_allclose(frame["mean"], TWO_SLOPES(frame["tasks"].to_numpy()) + (RUNS - 1) / 2, rtol=1e-5)
    assert frame["slope_before"].unique() == pytest.approx([0.6], rel=1e-5)
    assert frame["slope_after"].unique() == pytest.approx([0.2], rel=1e-5)


def test_library_cost_numbers(frames: dict[str, pd.DataFrame]) -> None:
    frame = frames["library-cost"]
    assert frame["seconds_per_skill"].dropna().unique() == pytest.approx([1e-7], rel=1e-4)
    storage = frame[frame["kind"] == "storage"]
    assert (storage["bytes"] == storage["states"] * storage["skills"]).all()
    assert len(storage) == 6


# -- pieces -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("before", "after"), [(0.6, 0.1), (0.1, 0.8), (0.3, 0.3)])
def test_fit_recovers_known_slopes_in_noise(before: float, after: float) -> None:
    tasks = np.arange(31)
    truth = TwoSlopes(7, 0.2, before, after)
    noise = np.random.default_rng(3).normal(0, 0.1, size=31)
    exact, noisy = (fit_two_slopes(tasks, truth(tasks) + scale * noise, 7) for scale in (0, 1))
    assert (exact.intercept, exact.before, exact.after) == pytest.approx((0.2, before, after))
    assert (noisy.before, noisy.after) == pytest.approx((before, after), abs=0.05)


def test_slope_intervals_cover_the_slopes() -> None:
    tasks = np.arange(31)
    random = np.random.default_rng(5)
    sizes = np.array([TwoSlopes(7, 0, random.normal(0.6, 0.1), random.normal(0.2, 0.05))(tasks) for _ in range(40)])
    row = growth_frame(tasks, sizes, 7).iloc[0]
    assert row["slope_before_low"] < row["slope_before"] < row["slope_before_high"]
    assert row["slope_before_high"] - row["slope_before_low"] == pytest.approx(2 * 1.96 * 0.1 / np.sqrt(40), rel=0.4)
    assert row["slope_after_low"] < row["slope_after"] < row["slope_after_high"]


def test_trailing_mean() -> None:
    np.testing.assert_allclose(trailing_mean(np.array([4.0, 2, 6, 1]), 2), [np.nan, 3, 4, 3.5])


def test_band_is_the_normal_interval_for_many_runs_and_missing_for_one() -> None:
    values = np.random.default_rng(1).normal(5, 2, size=(400, 3))
    mean, low, high = mean_band(values)
    np.testing.assert_allclose(mean, values.mean(axis=0))
    np.testing.assert_allclose(high - low, 2 * 1.96 * values.std(axis=0) / 20, rtol=0.1)
    assert np.isnan(mean_band(values[:1])[1]).all()


def test_colours_and_labels_of_methods_are_unique() -> None:
    looks = [style.method_look(name) for name in methods.names()]
    assert len({mpl.colors.to_hex(colour) for colour, _ in looks}) == len(looks)
    assert len({label for _, label in looks}) == len(looks)
    assert not {colour for colour, _ in looks} & set(style.CATEGORIES)


def test_heat_grows_darker_all_the_way() -> None:
    linear = style.HEAT(np.linspace(0, 1, 216))[:, :3]
    luminance = linear @ [0.2126, 0.7152, 0.0722]
    assert (np.diff(luminance) < 1e-3).all()
    assert luminance[0] == pytest.approx(1)


def test_pack_keeps_every_map_once_in_order_and_wide_ones_alone() -> None:
    rows = cells.pack([(12, 78), (12, 32), (21, 24)])
    assert [index for row in rows for index in row] == [0, 1, 2]
    assert rows[0] == [0]
    assert cells.pack([(5, 5)]) == [[0]]


@pytest.mark.parametrize("text", ["I.A\n", "I\n.\n.\n.\n.\n.\nA\n", "###\n#I#\n#A#\n###\n"])
@pytest.mark.parametrize("kind", ["map", "prior"])
def test_odd_maps_can_be_drawn(kind: str, text: str, tmp_path: Path) -> None:
    (tmp_path / "odd.txt").write_text(text)
    arguments = [kind, str(tmp_path / "odd.txt"), "--output", str(tmp_path / "odd.png")]
    arguments += ["--goal", "A"] if kind == "prior" else []
    assert CliRunner().invoke(command, arguments, catch_exceptions=False).exit_code == 0
    assert len(pd.read_csv(tmp_path / "odd.csv")) == (
        2 if kind == "map" else len(text.replace("\n", "").replace("#", ""))
    )


# -- refusals -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("kind", "more", "words"),
    [
        ("map", ["--output", "figure.pdf"], "end the name in .png"),
        ("prior", ["--goal", "Z"], "no goal 'Z'"),
        ("prior", ["--form", "flat"], "prior_form"),
        ("discovery", ["--tasks", "BX"], "no task X"),
        ("misleading-prior", ["--task", "Q"], "no task Q"),
        ("frequencies", ["--title", "Small"], "equals sign"),
        ("curves", ["--method", "magic"], "no method 'magic'"),
        ("curves", ["--task", "small=A"], "no task 'A'"),
        ("measures", ["--window", "61"], "too few for a window of 61"),
        ("growth", ["--breakpoint", "12"], "one beyond"),
        ("growth", ["--breakpoint", "0"], "two points"),
    ],
)
def test_refusals_name_the_fault(kind: str, more: list[str], words: str, inputs: Path, tmp_path: Path) -> None:
    with pytest.raises(UserError, match=words):
        run(kind, inputs, tmp_path / "figure.png", *more)
    assert list(tmp_path.iterdir()) == []


def test_files_of_two_maps_are_not_mixed(inputs: Path, tmp_path: Path) -> None:
    text = MAP.replace("I..", ".I.")
    world = GridWorld.from_text(text)
    life = learn_life(world, tasks_of(world, "ABC"), "ptl", PARAMETERS, 1, "small", 9)
    with open_learning(inputs / "seed_0.h5") as file:
        origin = {name: file.file.attrs[name] for name in ("environment", "method", "seed", "root_seed", "code")}
        origin["parameters"] = json.loads(file.file.attrs["parameters"])
    write_learning(tmp_path / "other.h5", life, world, origin)
    for kind in ("discovery", "misleading-prior"):
        with pytest.raises(UserError, match="map"):
            run(kind, inputs, tmp_path / "figure.png", str(tmp_path / "other.h5"))


@pytest.mark.parametrize(
    ("kind", "argument", "text", "words"),
    [
        ("growth", 0, "run,tasks\n0,0\n", "no column 'library_size'"),
        ("growth", 0, "run,tasks,library_size\n0,0,0\n0,1,1\n1,0,0\n", "different numbers of tasks"),
        ("growth", 0, "", "cannot be read as CSV"),
        ("library-cost", 0, "skills,seconds\n1,0.1\n", "two library sizes"),
        ("library-cost", 0, "skills,seconds\n1,0.1\n2,fast\n", "'seconds'"),
        ("library-cost", 1, "states,bytes\n1,1\n", "no column 'skills'"),
    ],
)
def test_bad_tables_are_refused(kind: str, argument: int, text: str, words: str, inputs: Path, tmp_path: Path) -> None:
    (tmp_path / "bad.csv").write_text(text)
    arguments = ARGUMENTS[kind](inputs)
    arguments[argument] = str(tmp_path / "bad.csv")
    with pytest.raises(UserError, match=words):
        CliRunner().invoke(
            command, [kind, *arguments, "--output", str(tmp_path / "figure.png")], catch_exceptions=False
        )
    assert [path.name for path in tmp_path.iterdir()] == ["bad.csv"]
