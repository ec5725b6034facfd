"""A file is used only for the question that it answers, and a product only for the run that it was made for."""

from __future__ import annotations

import json
import os
import shutil
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner
from damage import rewrite
from lives import QUICK, ROOMS, ROOT_SEED, write_life
from projects import Project

from ptl.cli import commands
from ptl.config import Configuration
from ptl.errors import UserError
from ptl.files.manifest import _content
from ptl.files.outside import learning_code
from ptl.files.question import SIDE_MAPS, asking, question_of
from ptl.files.records import check_records, write_record
from ptl.files.results import read_result
from ptl.files.schema import GROWTH, LEARNING
from ptl.world.gridworld import GridWorld, map_digest

PAIRED = "results and products paired with another run, all refused"

CONFIG: dict[str, Any] = Configuration.from_dict(
    {
        "run": "small", "root_seed": ROOT_SEED, "seeds": 1, "methods": ["ptl", "no_transfer"],
        "environments": {"rooms": {"map": "rooms.txt", "title": "Rooms", "tasks": "AB"}},
        "growth": {"environment": "rooms"}, "measures": {"window": 5}, **QUICK.to_dict(),
    }
).to_dict()  # fmt: skip
MAPS = {"rooms": map_digest(ROOMS.text), **dict.fromkeys(SIDE_MAPS, "-")}


@pytest.fixture
def life(tmp_path: Path) -> Path:
    return write_life(tmp_path / "learning", "ptl", tasks="AB")


def with_(**changes: Any) -> dict[str, Any]:
    changed = json.loads(json.dumps(CONFIG))
    for name, value in changes.items():
        *groups, key = name.split("__")
        place = changed
        for group in groups:
            place = place[group]
        place[key] = value
    return changed


def test_a_file_of_the_run_is_read(life: Path) -> None:
    with asking(question_of(CONFIG, MAPS)):
        assert "".join(read_result(life).file["tasks"]) == "AB"


@pytest.mark.parametrize(
    ("question", "fault"),
    [
        (question_of(with_(root_seed=ROOT_SEED + 1), MAPS), "made with the root_seed 1, not 2"),
        (question_of(with_(learning__alpha=0.7), MAPS), "made with learning.alpha 0.05, not 0.7"),
        (question_of(with_(skills__patience=3.0), MAPS), "made with skills.patience 1.0, not 3.0"),
        (question_of(with_(environments__rooms__tasks="BA"), MAPS), "holds tasks AB, not BA"),
        (question_of(CONFIG, {**MAPS, "rooms": "0" * 16}), "made on another map"),
    ],
)
def test_a_file_that_answers_another_question_is_refused(
    question: Any, fault: str, life: Path, record_property: Callable[[str, int], None]
) -> None:
    record_property(PAIRED, 1)
    with asking(question), pytest.raises(UserError, match=fault):
        read_result(life)
    read_result(life)  # sound by itself


def test_a_file_in_the_place_of_another_is_refused(life: Path) -> None:
    other = life.with_name("seed_001.h5")
    other.write_bytes(life.read_bytes())
    with asking(question_of(CONFIG, MAPS)), pytest.raises(UserError, match=r"holds the job rooms/ptl/seed_000\.h5"):
        read_result(other)


def test_a_file_of_other_code_is_refused(life: Path) -> None:
    rewrite(life, lambda file: file.attrs.modify("code", "0" * 16))
    with asking(question_of(CONFIG, MAPS)), pytest.raises(UserError, match="another version of the code"):
        read_result(life)


def test_a_map_has_one_digest_however_it_is_written() -> None:
    assert map_digest(GridWorld.from_text(ROOMS.text.rstrip() + "\n\n").text) == MAPS["rooms"]


# -- records ------------------------------------------------------------------------------------------------------


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    """Two jobs: a table made from a result, and a page made from the table."""
    monkeypatch.chdir(tmp_path)
    for name in ("result", "table", "page"):
        Path(name).write_text(name)
    params = {"groups": {"measures": CONFIG["measures"]}, "asked": question_of(CONFIG, MAPS), "code": "1"}
    write_record(Path(), "measure", "measure", params, ["result"], ["table"])
    write_record(
        Path(), "tabulate", "tabulate", {"looks": {"ptl": [], "no_transfer": []}, "code": "2"}, ["table"], ["page"]
    )
    return {"config": CONFIG, "question": question_of(CONFIG, MAPS), "codes": {"measure": "1", "tabulate": "2"}}


def test_products_with_their_records_are_accepted(run: dict[str, Any]) -> None:
    check_records(Path(), ["page"], **run)


@pytest.mark.parametrize(
    ("change", "fault"),
    [
        (lambda run: Path("page").write_text("x"), "page: is not what its job made"),
        (lambda run: Path("table").write_text("x"), "page: was made from another table, and 1 more"),
        (lambda run: Path("result").write_text("x"), "table: was made from another result"),
        (lambda run: Path("result").unlink(), "table: result: cannot be read"),
        (lambda run: Path("records/tabulate.record.json").unlink(), "page: no record says what it was made from"),
        (lambda run: Path("records/tabulate.record.json").write_text("{}"), "is not a record"),
        (lambda run: run.update(config=with_(measures__window=3)), "made with measures.window 5, not 3"),
        (lambda run: run.update(config=with_(methods=["ptl"])), "page: was made for other methods"),
        (lambda run: run.update(config=with_(methods=["no_transfer", "ptl"])), "page: was made for other methods"),
        (lambda run: run.update(codes={"tabulate": "3"}), "page: was made by another version of the code"),
        (
            lambda run: run.update(question=question_of(with_(learning__alpha=0.7), MAPS)),
            "table: was made with parameters.learning.alpha 0.05, not 0.7",
        ),
    ],
)
def test_products_of_another_run_are_refused(
    change: Callable[[dict[str, Any]], Any],
    fault: str,
    run: dict[str, Any],
    record_property: Callable[[str, int], None],
) -> None:
    record_property(PAIRED, 1)
    change(run)
    with pytest.raises(UserError, match=fault):
        check_records(Path(), ["page"], **run)


@pytest.mark.parametrize(
    "change",
    [
        {"params": {"asked": []}}, {"params": {"asked": {LEARNING: 1}}}, {"params": {"asked": {LEARNING: {"maps": 1}}}},
        {"params": {"asked": {LEARNING: {"methods": ["ptl"]}}}}, {"params": {"asked": {LEARNING: {"jobs": None}}}},
        {"params": {"groups": [1]}}, {"params": {"study": 1}}, {"params": {"environments": ["rooms"]}},
        {"params": {"foreign": None}}, {"inputs": {"result": 1}}, {"outputs": {"table": "0"}}, {"rule": "--all"},
    ],
    ids=str,
)  # fmt: skip
def test_records_of_another_shape_are_refused(change: dict[str, Any], run: dict[str, Any]) -> None:
    path = Path("records/measure.record.json")
    path.write_text(json.dumps({**json.loads(path.read_text()), **change}))
    with pytest.raises(UserError, match=r"measure\.record\.json: is not a record \("):
        check_records(Path(), ["page"], **run)


@pytest.mark.parametrize(
    ("rule", "asked"),
    [
        ("measure", {"nope": {}}), ("measure", {GROWTH: {"methods": {"ptl": {}}}}), ("judge_settings", {LEARNING: {}}),
        ("judge_settings", {LEARNING: {"jobs": {"a": 1}}}),
    ],
)  # fmt: skip
def test_records_of_other_questions_are_refused(rule: str, asked: dict[str, Any], run: dict[str, Any]) -> None:
    write_record(Path(), "measure", rule, {"asked": asked}, ["result"], ["table"])
    with pytest.raises(UserError, match="table: was made"):
        check_records(Path(), ["table"], **run)


def test_results_are_not_paired_with_another_configuration(tiny: Project) -> None:
    """Neither without what Snakemake remembers, nor with a map that is older than what was made from it."""
    config, rooms = tiny.config, tiny.folder / "rooms.txt"
    state = (tiny.folder / ".snakemake").rename(tiny.folder / ".kept")
    text = rooms.read_text()
    try:
        tiny.configure({**config, "learning": {**config["learning"], "alpha": 0.7}})
        done = tiny.snakemake()
        assert done.returncode != 0
        assert "was made with parameters.learning.alpha 0.05, not 0.7" in done.stdout + done.stderr
        assert "'snakemake --cores 1 --forcerun learn" in done.stdout + done.stderr
        tiny.configure(config)
        rooms.write_text(text.replace("#..B#", "#.B.#"))
        os.utime(rooms, (946_684_800, 946_684_800))
        done = tiny.snakemake()
        assert done.returncode != 0 and "was made with maps.rooms" in done.stdout + done.stderr
    finally:
        rooms.write_text(text)
        tiny.configure(config)
        shutil.rmtree(tiny.folder / ".snakemake")
        state.rename(tiny.folder / ".snakemake")
    assert set(tiny.waiting()) == {"manifest", "all"}  # only the manifest was given up
    tiny.make()


def test_verify_holds_results_against_the_configuration_of_their_run(tiny: Project) -> None:
    made = tiny.folder / "results/tiny/made.json"
    whole = made.read_text()
    assert "not held against" not in tiny.ptl("verify", "results/tiny").stdout
    manifest = json.loads(whole)
    manifest["config"]["learning"]["alpha"] = 0.7
    manifest["content"] = _content(manifest)
    try:
        made.write_text(json.dumps(manifest))
        done = tiny.ptl("verify", "results/tiny/learning")
        assert done.returncode == 1 and "Traceback" not in done.stderr
        assert "was made with learning.alpha 0.05, not 0.7" in done.stdout
        del manifest["config"]["learning"], manifest["maps"]["rooms"]
        manifest["content"] = _content(manifest)
        made.write_text(json.dumps(manifest))
        done = tiny.ptl("verify", "results/tiny/learning")
        assert done.returncode == 1 and done.stderr.startswith("error: ") and done.stderr.count("\n") == 1
        assert "names no map of rooms" in done.stderr
        made.unlink()
        done = tiny.ptl("verify", "results/tiny/learning")
        assert done.returncode == 0 and "not held against the configuration of a run" in done.stdout
    finally:
        made.write_text(whole)


# -- methods from elsewhere --------------------------------------------------------------------------------------


MINE = """
from typing import Annotated

from ptl.keys import Group, key
from ptl.methods.no_transfer import Method as NoTransfer


class Own(Group, frozen=True, kw_only=True):
    start: Annotated[float, key("Start.", ge=0, le=1)] = 1.0


class Method(NoTransfer):
    label = "Mine"
    colour = "#123456"
    own = Own()
"""


@pytest.fixture
def mine(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A life by a method that is a file of this folder."""
    monkeypatch.chdir(tmp_path)
    Path("starting.py").write_text(MINE)
    Path("rooms.txt").write_text(ROOMS.text)
    life = Path("learning/rooms/starting/seed_000.h5")
    arguments = (
        f"learn --map rooms.txt --environment rooms --tasks AB --method starting.py --seed 0 --root-seed {ROOT_SEED}"
    )
    parameters = json.dumps(QUICK.to_dict())
    CliRunner().invoke(
        commands, [*arguments.split(), "--parameters", parameters, "--output", str(life)], catch_exceptions=False
    )
    return life


@pytest.mark.parametrize(
    ("changes", "codes", "fault"),
    [
        ({"methods": ["ptl"]}, None, "is of the method starting, which is not in the run"),
        ({"methods": ["other/starting.py"]}, None, "was made by the method starting.py, not by other/starting.py"),
        ({"method_parameters": {"starting": {"start": 0.0}}}, None, "was made with starting's parameters"),
        ({}, {"starting": "0" * 16}, "was made by another version of the method starting"),
    ],
)
def test_a_life_by_another_method_is_refused(mine: Path, changes: Any, codes: Any, fault: str) -> None:
    config = with_(**{"methods": ["starting.py"], "method_parameters": {"starting": {"start": 1.0}}, **changes})
    with asking(question_of(config, MAPS, codes)), pytest.raises(UserError, match=fault):
        read_result(mine)


def test_a_life_by_the_method_of_the_run_is_read(mine: Path) -> None:
    config = with_(methods=["starting.py"], method_parameters={"starting": {"start": 1.0}})
    with asking(question_of(config, MAPS, {"starting": learning_code("starting.py")})):
        assert read_result(mine).method == "starting"


def test_products_with_a_method_that_left_the_run_are_refused_by_name(run: dict[str, Any]) -> None:
    """The command that mends makes the products again and learns nothing."""
    params = {"asked": {LEARNING: question_of(CONFIG, MAPS)[LEARNING]}, "methods": ["ptl", "no_transfer"], "code": "1"}
    write_record(Path(), "measure", "measure", params, ["result"], ["table"])
    fewer = with_(methods=["ptl"])
    with pytest.raises(UserError, match="lives under no_transfer") as refused:
        check_records(Path(), ["table"], fewer, question_of(fewer, MAPS), run["codes"])
    assert "learn" not in str(refused.value).partition("--forcerun")[2]


def test_verify_imports_nothing_that_a_manifest_names(
    tmp_path: Path, life: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("evil.py").write_text("open('imported', 'w')\n")
    for config in (with_(methods=["evil:Method"]), {"population": "p.csv", "methods": ["evil:Method"]}):
        manifest = {"config": config, "maps": MAPS, "versions": {}, "products": {"a": "0" * 64}}
        Path("made.json").write_text(json.dumps({**manifest, "content": _content(manifest)}))
        done = CliRunner().invoke(commands, ["verify", str(life)], catch_exceptions=False)
        assert "not held against the configuration" in done.output
        assert not Path("imported").exists() and "evil" not in sys.modules
