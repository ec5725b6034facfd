"""Every figure is made from small inputs: files, their bytes, numbers against the inputs, refusals."""

from __future__ import annotations

from collections.abc import Iterator
from importlib import import_module
from itertools import combinations
from pathlib import Path
from types import SimpleNamespace
from typing import get_args

import matplotlib as mpl
import numpy as np
import pandas as pd
import pytest
from lives import job, read_lives, write_life
from matplotlib.backends.backend_agg import FigureCanvasAgg

from ptl import methods
from ptl.agent.selection import prior
from ptl.claims.degrees import CLASSES
from ptl.config import Environment, Learning, Parameters, Skills, Statistics
from ptl.errors import UserError
from ptl.files import store
from ptl.jobs.learn import skills_of, tasks_in
from ptl.jobs.survey import Survey
from ptl.measures.growth import Saturation, TwoSlopes, fit_saturation
from ptl.measures.measures import PER_SEED_COLUMNS
from ptl.measures.run_files import read_steps, write_steps
from ptl.report.figures import cells, curves, figures, front, heading, item_label, left_out, on_page, saving, style
from ptl.report.figures.algorithms import algorithms
from ptl.report.figures.discovery import DOT, _diameter
from ptl.report.figures.measures import trailing_mean
from ptl.report.ledger import STYLES
from ptl.report.script import Script
from ptl.world.gridworld import GridWorld, map_digest

MAP = """\
#########
#I..#..A#
#.......#
#...#..B#
##.######
#......C#
#########
"""
SMALL = GridWorld.from_text(MAP, "small")
PARAMETERS = Parameters.from_dict({"learning": {"episodes": 30}, "subgoals": {"trajectories": 10}})
SEEDS, RUNS = 5, 5
TWO_SLOPES = TwoSlopes(bend=7, intercept=0, before=3, after=1)
LIVES = [job("ptl", seed, world=SMALL, parameters=PARAMETERS) for seed in range(SEEDS)]
SURVEY = Survey(
    root_seed=1, parameters={"learning": Learning().to_dict()}, maps={"small": map_digest(MAP)}, code="0" * 16,
    environment="small", trajectories=5, starts=3,
)  # fmt: skip


@pytest.fixture(scope="module", autouse=True)
def coarse_pictures() -> Iterator[None]:
    """Fewer dots than the published figures have, because painting dots takes time."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(saving, "PNG_RESOLUTION", 60)
        yield


@pytest.fixture(scope="module")
def inputs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with one small input of every kind, real runs wherever runs are drawn."""
    folder = tmp_path_factory.mktemp("figures")
    (folder / "small.txt").write_text(MAP)
    for work in LIVES:
        write_life(folder, "ptl", work.seed, world=SMALL, parameters=PARAMETERS)
    store.write(folder / SURVEY.place, SURVEY, SURVEY.run({"small": SMALL}), {"small": SMALL})
    random = np.random.default_rng(0)
    steps = {
        ("small", method, "C"): random.poisson(np.geomspace(400 / (index + 1), 9, 60), size=(SEEDS, 60)) + 9
        for index, method in enumerate(METHODS)
    }
    write_steps(folder / "steps.h5", steps)
    tasks = np.arange(13)
    pd.DataFrame(
        {
            "run": np.repeat(np.arange(RUNS), len(tasks)),
            "tasks": np.tile(tasks, RUNS),
            "library_size": np.concatenate([TWO_SLOPES(tasks).astype(int) + run for run in range(RUNS)]),
        }
    ).to_csv(folder / "growth.csv", index=False)
    skills = np.array([1, 10, 100])
    pd.DataFrame({"skills": skills, "operations": 3 + 7 * skills}).to_csv(folder / "selection.csv", index=False)
    storage = [(states, count, states * count) for states in (20, 50) for count in skills]
    pd.DataFrame(storage, columns=["states", "skills", "bytes"]).to_csv(folder / "storage.csv", index=False)
    rows = [
        ("small", task, method, seed, int(random.integers(100, 200)) * (1 + index) * (1 + (task == "C")))
        for index, method in enumerate(METHODS)
        for task in "ABC"
        for seed in range(SEEDS)
    ]
    frame = pd.DataFrame(rows, columns=["environment", "task", "method", "seed", "total_steps"])
    frame.reindex(columns=[*PER_SEED_COLUMNS]).fillna(1).to_csv(folder / "per_seed.csv", index=False)
    classes = [name for name in CLASSES for _ in range(3)]
    ids = [f"claim-{place}" for place in range(len(classes))]
    pd.DataFrame({"id": ids, "class": classes[::-1]}).to_csv(folder / "claims.csv", index=False)
    return folder


GROUPS = {
    "measures": {"window": 10, "threshold_factor": 1.5},
    "statistics": {"confidence": 0.95, "resamples": 500},
    "growth": {"breakpoint": 7},
}
INPUTS = {
    "front": {"per_seed": "per_seed.csv", "claims": "claims.csv"},
    "front_narrow": {"per_seed": "per_seed.csv", "claims": "claims.csv"},
    "clusters": {},
    "algorithms": {},
    "maps": {},
    "prior": {},
    "misleading_prior": {"misleading_prior": [work.place for work in LIVES]},
    "frequencies": {"survey": [SURVEY.place]},
    "discovery": {"learning": [work.place for work in LIVES]},
    "curves": {"steps": "steps.h5"},
    "measures": {"steps": "steps.h5"},
    "growth": {"growth": "growth.csv"},
    "library_cost": {"selection_cost": "selection.csv", "library_bytes": "storage.csv"},
}
"""Input files of every figure that needs no separate study, by module."""

METHODS = ["no_transfer", "full_transfer", "policy_reuse", "ptl"]


def script(kind: str, folder: Path, entry: dict | None = None, files: dict | None = None, **changes: dict) -> Script:
    """A script of the workflow on the small inputs; ``changes`` go into the groups of the configuration."""

    def placed(names: str | list[str]) -> str | list[str]:
        return str(folder / names) if isinstance(names, str) else [str(folder / name) for name in names]

    inputs = {name: placed(names) for name, names in INPUTS[kind].items()} | (files or {})
    groups = {name: SimpleNamespace(**(group | changes.get(name, {}))) for name, group in GROUPS.items()}
    groups |= {name: getattr(Parameters(), name) for name in ("learning", "skills", "subgoals")}
    settings = {"map": str(folder / "small.txt"), "title": "Small", "tasks": "ABC", "discovery_tasks": "BC"}
    compared = ["no_transfer", "ptl"] if kind == "measures" else METHODS
    looks = {name: (methods.load(name).label, methods.load(name).colour) for name in compared}
    environments = {"small": Environment(**(settings | (entry or {})))}
    return Script(
        SimpleNamespace(**inputs), None, SimpleNamespace(**groups), environments, compared, own_looks=looks,
        jobs=[*LIVES, SURVEY],
    )  # fmt: skip


def draw(kind: str, output: Path, given: Script) -> None:
    """Draw a figure as the workflow's script does."""
    saving.save(*import_module(f"ptl.report.figures.{kind}").make(given), output)


@pytest.fixture(scope="module")
def lives(inputs: Path) -> list[store.Result]:
    """The learning files."""
    return read_lives(*(inputs / work.place for work in LIVES))


@pytest.fixture(scope="module")
def frames(inputs: Path) -> dict[str, pd.DataFrame]:
    """The CSV twin of every figure, by module."""
    for kind in INPUTS:
        draw(kind, inputs / "out" / f"{kind}.png", script(kind, inputs))
    return {kind: pd.read_csv(inputs / "out" / f"{kind}.csv", keep_default_na=False, na_values=[""]) for kind in INPUTS}


def test_every_module_of_the_registry_is_tested() -> None:
    config = {
        "seeds": 30, "methods": METHODS, "growth": {"runs": 3, "breakpoint": 7}, "statistics": {"confidence": 0.95},
        "subgoal_frequencies": {"starts": "all", "trajectories": 5},
        "environments": {"small": {"title": "", "tasks": "ABC", "article_items": {}}},
    }  # fmt: skip
    rows = figures(config, article=True)
    assert {row.module for row in rows.values()} == {*INPUTS}
    assert set(figures({**config, "methods": ["no_transfer"]}, article=True)) == set(rows) - {
        "figure04", "discovery_small", "figure13", "front", "front_narrow",
    }  # fmt: skip
    only_one = {"small": config["environments"]["small"] | {"tasks": "A"}}
    assert set(rows) - set(figures({**config, "environments": only_one}, article=True)) == {"front", "front_narrow"}
    assert left_out(config, article=True) == {}
    assert left_out({**config, "methods": ["no_transfer"]}, article=True) == {
        "figure04": "ptl", "discovery_small": "ptl", "figure13": "ptl", "front": "ptl", "front_narrow": "ptl",
    }  # fmt: skip
    # away from the article's maps no figure has a number of the article, and none is about it or its sources
    own = figures(config, article=False)
    assert set(own) == {
        "front", "front_narrow", "prior", "map_small",
        "frequencies", "discovery_small", "curves", "measures", "growth", "library_cost"
    }  # fmt: skip
    assert all(row.item for row in own.values())
    assert not any("article" in row.caption or "article" in row.shows for row in own.values())
    # results come first on the page, then the maps
    assert list(on_page(own))[:4] == ["curves", "measures", "discovery_small", "map_small"]
    assert set(own) - set(on_page(own)) == {"front", "front_narrow"}
    assert heading("library_cost", own["library_cost"]) == "Cost of a selection and size of a library"


@pytest.mark.parametrize("kind", INPUTS)
def test_same_inputs_give_the_same_bytes_whatever_the_settings(
    kind: str, inputs: Path, frames: dict[str, pd.DataFrame], tmp_path: Path
) -> None:
    with mpl.rc_context({"font.size": 30, "svg.hashsalt": None, "axes.grid": False, "savefig.bbox": "tight"}):
        draw(kind, tmp_path / f"{kind}.png", script(kind, inputs))
    for suffix in (".png", ".svg", ".csv"):
        again = (tmp_path / f"{kind}{suffix}").read_bytes()
        assert again == (inputs / "out" / f"{kind}{suffix}").read_bytes()
    assert b"<dc:date>" not in (tmp_path / f"{kind}.svg").read_bytes()


@pytest.mark.parametrize("kind", INPUTS)
def test_picture_has_ink_and_nothing_is_cut_off(kind: str, inputs: Path, frames: dict[str, pd.DataFrame]) -> None:
    from matplotlib.image import imread

    paper = imread(inputs / "out" / f"{kind}.png")[..., :3].min(axis=2) > 0.99
    assert 0.01 < (~paper).mean() < 0.9
    # a margin of 2 dots all around stays white: labels that are cut off would cross it
    for edge in (paper[:2], paper[-2:], paper[:, :2], paper[:, -2:]):
        assert edge.all()


# -- numbers ------------------------------------------------------------------------------------------------


def test_map_numbers(frames: dict[str, pd.DataFrame]) -> None:
    world, frame = SMALL, frames["maps"]
    assert frame["letter"].tolist() == ["I", "A", "B", "C"]
    assert frame["state"].tolist() == [world.start, *world.goals.values()]
    assert frame["shortest_path"].tolist() == [
        world.shortest_path_length(world.start, state) for state in frame["state"]
    ]


def test_cluster_numbers(frames: dict[str, pd.DataFrame]) -> None:
    frame = frames["clusters"].set_index("state")
    assert frame.groupby("cluster").size().to_dict() == {0: 49, 1: 49}
    assert frame["cluster"].isna().sum() == 1, "the door is in neither"
    assert frame["metric"].between(0, 1).all()
    door = frame[frame["cluster"].isna()].iloc[0]
    near = frame[(frame["row"] == door["row"]) & ((frame["column"] - door["column"]).abs() <= 1)]
    assert near["subgoals"].sum() > 20, "most lives find the door or a cell beside it"
    assert near["metric"].min() > frame.drop(near.index)["metric"].quantile(0.9)


def test_algorithms_have_the_constants_of_the_run() -> None:
    settings = Parameters(alpha=0.25, prior_width=0.3, patience=3.0, novelty=0.31, cover_radius=4, trajectories=17)
    constants = " ".join(algorithms(settings)["constants"])
    for value in ("α = 0.25", "3 × number of states", "ρ = 0.31", "r = 4", "T = 17"):
        assert value in constants
    for use in get_args(get_args(Skills.__annotations__["skill_use"])[0]):
        text = " ".join(algorithms(Parameters(skill_use=use))["text"])
        assert ("initiation set" in text) == (use == "initiation_set")


def test_prior_numbers(frames: dict[str, pd.DataFrame]) -> None:
    world, frame = SMALL, frames["prior"]
    distance = np.hypot(*(world.cells - world.cells[world.goal("C")]).T)
    np.testing.assert_allclose(frame["relative_prior"], np.exp(-distance / (0.1 * world.diagonal)), rtol=1e-5)


def test_misleading_prior_numbers(lives: list[store.Result], frames: dict[str, pd.DataFrame]) -> None:
    frame = frames["misleading_prior"]
    np.testing.assert_allclose(frame.groupby("episode")["probability"].sum(), 1, rtol=1e-4)
    # the beginning is the prior
    expected: dict[str, list[float]] = {}
    for result in lives:
        task = tasks_in(result)["C"]
        known = [skill for skill in skills_of(result.arrays) or [] if skill.learned_after < 2]
        names = ["none", *("ABC"[skill.learned_after] for skill in known)]
        states = [task.start, *(skill.subgoal for skill in known)]
        for name, chance in zip(names, prior(SMALL.cells, states, task.goal, SMALL.diagonal), strict=True):
            expected.setdefault(name, []).append(chance)
    first = frame[frame["episode"] == 1].set_index("skill")["probability"]
    assert set(first.index) == set(expected)
    assert len(expected) > 1
    for name, chances in expected.items():
        assert first[name] == pytest.approx(sum(chances) / SEEDS, rel=1e-5)


def test_misleading_prior_probabilities_are_those_the_learner_drew_from(
    lives: list[store.Result], monkeypatch: pytest.MonkeyPatch
) -> None:
    from ptl.methods.ptl import Method
    from ptl.report.figures import misleading_prior

    drawn: list[np.ndarray] = []
    original = Method.run_episode

    def watched(self: Method, learner: object) -> list[int]:
        drawn.append(self.selection.probabilities())
        return original(self, learner)

    monkeypatch.setattr(Method, "run_episode", watched)
    LIVES[0].run({"small": SMALL})
    frame = misleading_prior.collect(lives[:1], Statistics(), "C").frame
    names = list(dict.fromkeys(frame["skill"]))
    table = frame.pivot_table(index="episode", columns="skill", values="probability")
    candidates = ["none", *(name for name in names if name != "none")]
    np.testing.assert_allclose(table[candidates], np.array(drawn[-30:]), rtol=1e-12)


def test_frequency_numbers(inputs: Path, frames: dict[str, pd.DataFrame]) -> None:
    frame, arrays = frames["frequencies"], store.read(inputs / SURVEY.place, SURVEY).arrays
    assert frame["count"].tolist() == arrays["counts"].tolist()
    assert frame["count"].sum() + arrays["unresolved"] == arrays["pairs"]
    np.testing.assert_allclose(frame["share"], 100 * arrays["counts"] / arrays["pairs"], rtol=1e-5)


def test_discovery_numbers(lives: list[store.Result], frames: dict[str, pd.DataFrame]) -> None:
    for (task, metric), part in frames["discovery"].groupby(["task", "metric"]):
        values, chosen = [], np.zeros(len(part), dtype=int)
        for result in lives:
            view = tasks_in(result)[task]
            values.append(getattr(view, metric))
            choice = view.subgoal if metric == "incremental" else int(view.original.argmax())
            if choice >= 0:
                chosen[choice] += 1
        np.testing.assert_allclose(part["value"], np.mean(values, axis=0), rtol=1e-5)
        assert part["chosen"].tolist() == chosen.tolist()
    assert set(frames["discovery"]["task"]) == {"B", "C"}


def test_curve_numbers(inputs: Path, frames: dict[str, pd.DataFrame]) -> None:
    steps = read_steps(inputs / "steps.h5")
    for method, part in frames["curves"].groupby("method"):
        np.testing.assert_allclose(part["mean"], steps["small", method, "C"].mean(axis=0), rtol=1e-5)
        assert (part["ci_low"] <= part["mean"] * 1.00001).all()
        assert (part["ci_high"] >= part["mean"] * 0.99999).all()
    assert set(frames["curves"]["method"]) == set(METHODS)


def test_every_task_has_a_panel_with_its_curves(inputs: Path) -> None:
    both = {("small", "ptl", task): np.full((SEEDS, 5), 100 * place) for place, task in enumerate("CA", start=1)}
    frame = curves.curves(both, {"small": SMALL}, {"small": "CA"}, METHODS, Statistics(resamples=100))
    figure = curves.draw(frame, {"small": "A room"}, {"ptl": ("PTL", "#0072b2")})
    assert [axes.get_title(loc="left") for axes in figure.axes] == ["A room, task C", "A room, task A"]
    assert [axes.lines[0].get_ydata().tolist() for axes in figure.axes] == [[100.0] * 5, [200.0] * 5]


def test_measure_numbers(inputs: Path, frames: dict[str, pd.DataFrame]) -> None:
    steps = read_steps(inputs / "steps.h5")
    base, mine = (steps["small", method, "C"] for method in ("no_transfer", "ptl"))
    row = frames["measures"].query("method == 'ptl'").iloc[-1]
    assert row["jump_start"] == pytest.approx((base[:, 0] - mine[:, 0]).mean(), rel=1e-5)
    assert row["asymptotic"] == pytest.approx(mine[:, -10:].mean(), rel=1e-5)
    assert row["threshold"] == pytest.approx(1.5 * SMALL.shortest_path_length(SMALL.start, SMALL.goal("C")))
    means = [mine[:, end - 10 : end].mean() for end in range(10, 61)]
    reached = [end for end, mean in enumerate(means, start=10) if mean <= row["threshold"]]
    assert row["threshold_episode"] == reached[0] if reached else np.isnan(row["threshold_episode"])


def test_growth_numbers(frames: dict[str, pd.DataFrame]) -> None:
    frame = frames["growth"]
    np.testing.assert_allclose(frame["mean"], TWO_SLOPES(frame["tasks"].to_numpy()) + (RUNS - 1) / 2, rtol=1e-5)
    assert frame["slope_before"].unique() == pytest.approx([TWO_SLOPES.before], rel=1e-5)
    assert frame["slope_after"].unique() == pytest.approx([TWO_SLOPES.after], rel=1e-5)


def test_library_cost_numbers(frames: dict[str, pd.DataFrame]) -> None:
    frame = frames["library_cost"]
    assert frame["operations_per_skill"].dropna().unique() == pytest.approx([7], rel=1e-4)
    storage = frame[frame["kind"] == "storage"]
    assert (storage["bytes"] == storage["states"] * storage["skills"]).all()
    assert len(storage) == 6


# -- pieces -------------------------------------------------------------------------------------------------


def test_trailing_mean() -> None:
    np.testing.assert_allclose(trailing_mean(np.array([4.0, 2, 6, 1]), 2), [np.nan, 3, 4, 3.5])


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
@pytest.mark.parametrize("kind", ["maps", "prior"])
def test_odd_maps_can_be_drawn(kind: str, text: str, tmp_path: Path) -> None:
    (tmp_path / "odd.txt").write_text(text)
    draw(kind, tmp_path / "odd.png", script(kind, tmp_path, {"map": str(tmp_path / "odd.txt"), "tasks": "A"}))
    assert len(pd.read_csv(tmp_path / "odd.csv")) == (2 if kind == "maps" else len(text.translate({10: "", 35: ""})))


@pytest.mark.parametrize("kind", ["maps", "prior", "discovery", "curves", "measures", "frequencies"])
def test_a_dollar_sign_in_a_title_starts_no_formula(kind: str, inputs: Path, tmp_path: Path) -> None:
    draw(kind, tmp_path / "figure.png", script(kind, inputs, {"title": r"$\spam$ for $5"}))
    assert (tmp_path / "figure.png").is_file()


def test_a_saturating_curve_is_found() -> None:
    tasks = np.arange(31)
    found = fit_saturation(Saturation(14.0, 16.0)(tasks))
    assert (found.limit, found.half) == (pytest.approx(14, rel=1e-3), pytest.approx(16, rel=1e-3))
    assert found(np.array([0, 16])).tolist() == [0, pytest.approx(7, rel=1e-3)]


def test_dots_of_discovery_stay_in_their_cells() -> None:
    sizes = _diameter(np.arange(1, 31), 30, 0.15)
    assert (np.diff(np.square(sizes)) == pytest.approx(np.diff(np.square(sizes))[0])) and (np.diff(sizes) > 0).all()
    assert sizes[-1] == pytest.approx(DOT[1] * 0.15 * cells.POINTS_PER_INCH) and DOT[1] < 1


def test_item_labels_have_no_leading_zero() -> None:
    assert item_label("figure03", SimpleNamespace(item="")) == "Figure 3"


# -- the picture on the first page --------------------------------------------------------------------------


def test_claims_of_the_picture_are_in_the_order_of_the_classes(frames: dict[str, pd.DataFrame]) -> None:
    strip = frames["front"].dropna(subset="class")
    assert list(dict.fromkeys(strip["class"])) == list(CLASSES) == list(style.CLASS_COLOURS)
    assert strip["id"].tolist() == [
        f"claim-{place}" for start in range(15, -1, -3) for place in range(start, start + 3)
    ]
    pd.testing.assert_frame_equal(frames["front"], frames["front_narrow"])


def test_colours_of_classes_differ_in_lightness_as_on_the_pages() -> None:
    def lightness(colour: str) -> float:
        linear = [
            part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in mpl.colors.to_rgb(colour)
        ]
        luminance = np.dot(linear, [0.2126, 0.7152, 0.0722])
        return float(116 * np.cbrt(luminance) - 16)

    assert np.diff(sorted(map(lightness, style.CLASS_COLOURS.values()))).min() > 8
    sheet = (Path(front.__file__).parents[1] / "templates/ledger.css").read_text()
    for name, kind in STYLES.items():
        assert f"--{kind}: {style.CLASS_COLOURS[name]};" in sheet


def test_ratios_of_the_picture_are_those_of_the_means(inputs: Path, frames: dict[str, pd.DataFrame]) -> None:
    steps = frames["front"].dropna(subset="ratio")
    assert list(dict.fromkeys(steps["tasks"])) == ["BC", "B", "C"]
    assert "no_transfer" not in set(steps["method"])
    means = pd.read_csv(inputs / "per_seed.csv").groupby(["method", "task"])["total_steps"].mean()
    for row in steps.to_dict("records"):
        own, base = (sum(means[method, task] for task in row["tasks"]) for method in (row["method"], "no_transfer"))
        assert row["ratio"] == pytest.approx(own / base, rel=1e-4)
        assert row["low"] < row["ratio"] < row["high"]


def test_labels_of_the_picture_do_not_overlap(frames: dict[str, pd.DataFrame]) -> None:
    """With as many claims and names as long as the article's."""
    claims = front.in_order(pd.DataFrame({"id": ["E1-asymptotic"] * 24, "class": [*CLASSES] * 4}))
    frame = frames["front"].dropna(subset="ratio")
    frame = pd.concat([frame.assign(environment=name) for name in ("one", "two", "three")])
    looks = {name: style.method_look(name)[::-1] for name in METHODS}
    for narrow in (False, True):
        picture = front.draw(frame, claims, {}, looks, narrow)
        canvas = FigureCanvasAgg(picture)
        canvas.draw()
        width, height = picture.canvas.get_width_height()
        boxes = [
            words.get_window_extent()
            for words in picture.findobj(mpl.text.Text)
            if words.get_visible() and words.get_text().strip() and not words.get_rotation() % 90
        ]
        assert all(box.x0 >= 0 and box.y0 >= 0 and box.x1 <= width and box.y1 <= height for box in boxes)
        overlaps = [
            1 for one, other in combinations(boxes, 2) if one.shrunk(0.96, 0.9).overlaps(other.shrunk(0.96, 0.9))
        ]
        assert not overlaps
        slanted = [
            words
            for words in picture.findobj(mpl.text.Text)
            if words.get_text() and words.get_rotation() == front.ANGLE and words.get_position()[1] == 0
        ]
        assert len(slanted) == (0 if narrow else 24)
        if slanted:
            places = sorted(words.get_window_extent().x1 for words in slanted)
            size = slanted[0].get_fontsize() * picture.dpi / 72
            assert np.diff(places).min() * np.sin(np.radians(front.ANGLE)) > size


# -- refusals -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("kind", "entry", "changes", "words"),
    [
        ("prior", {"tasks": "Z"}, {}, "no goal 'Z'"),
        ("measures", {}, {"measures": {"window": 61}}, "too few for a window of 61"),
        ("growth", {}, {"growth": {"breakpoint": 12}}, "12 is not allowed"),
    ],
)
def test_refusals_name_the_fault(
    kind: str, entry: dict, changes: dict, words: str, inputs: Path, tmp_path: Path
) -> None:
    with pytest.raises(UserError, match=words):
        draw(kind, tmp_path / "figure.png", script(kind, inputs, entry, **changes))
    assert list(tmp_path.iterdir()) == []


def test_figures_end_in_png(inputs: Path, tmp_path: Path) -> None:
    with pytest.raises(UserError, match=r"end the name in \.png"):
        draw("maps", tmp_path / "figure.pdf", script("maps", inputs))


@pytest.mark.parametrize(("kind", "name"), [("discovery", "learning"), ("misleading_prior", "misleading_prior")])
def test_a_file_of_another_job_is_refused(kind: str, name: str, inputs: Path, tmp_path: Path) -> None:
    """On another map here; each place has one job, so files of two runs are never drawn together."""
    other = GridWorld.from_text(MAP.replace("I..", ".I."), "small")
    files = {name: [inputs / LIVES[0].place, write_life(tmp_path, "ptl", 1, world=other, parameters=PARAMETERS)]}
    with pytest.raises(UserError, match=r"seed_001\.h5: was made with another map of small"):
        draw(kind, tmp_path / "figure.png", script(kind, inputs, files=files))


@pytest.mark.parametrize(
    ("kind", "name", "text", "words"),
    [
        ("growth", "growth", "run,tasks\n0,0\n", "no column 'library_size'"),
        ("growth", "growth", "run,tasks,library_size\n0,0,0\n0,1,1\n1,0,0\n", "different numbers of tasks"),
        ("growth", "growth", "", "cannot be read as CSV"),
        ("library_cost", "selection_cost", "skills,operations\n1,4\n", "two library sizes"),
        ("library_cost", "library_bytes", "states,bytes\n1,1\n", "no column 'skills'"),
    ],
)
def test_bad_tables_are_refused(kind: str, name: str, text: str, words: str, inputs: Path, tmp_path: Path) -> None:
    (tmp_path / "bad.csv").write_text(text)
    with pytest.raises(UserError, match=words):
        draw(kind, tmp_path / "figure.png", script(kind, inputs, files={name: str(tmp_path / "bad.csv")}))
    assert [path.name for path in tmp_path.iterdir()] == ["bad.csv"]
