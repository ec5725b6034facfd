"""Results of other programs: valid tables are read, others refused with one line before anything is learned."""

from __future__ import annotations

import csv
import os
from pathlib import Path

import numpy as np
import pytest
from projects import ROOMS

from ptl.errors import UserError
from ptl.files.configuration import completed
from ptl.files.foreign import COLUMNS, Expected, read_foreign, seeds_of
from ptl.world.gridworld import GridWorld

WORLD = GridWorld.from_text(ROOMS)
SEEDS, EPISODES = 2, 3
EXPECTED = Expected({"rooms": WORLD, "again": WORLD}, {"rooms": "AB", "again": "BA"}, SEEDS, EPISODES, 1000)


def rows(method: str = "walker", environments: tuple[str, ...] = ("rooms",)) -> list[dict[str, object]]:
    """A complete table; steps tell places apart."""
    return [
        {"environment": name, "method": method, "task": task, "seed": seed, "episode": episode,
         "steps": 100 * (task == "B") + 10 * seed + episode + 20}
        for name in environments for task in "AB" for seed in range(SEEDS) for episode in range(1, EPISODES + 1)
    ]  # fmt: skip


def write(path: Path, table: list[dict[str, object]], columns: tuple[str, ...] = COLUMNS) -> Path:
    with path.open("w", newline="") as file:
        writer = csv.DictWriter(file, columns)
        writer.writeheader()
        writer.writerows(table)
    return path


def refusal(path: Path, method: str = "walker") -> str:
    with pytest.raises(UserError) as caught:
        read_foreign(path, method, EXPECTED)
    text = str(caught.value)
    assert text.startswith(str(path)) and "\n" not in text
    return text.removeprefix(f"{path}: ")


def test_a_table_is_read_in_the_order_of_the_run_whatever_its_own_order(tmp_path):
    shuffled = np.random.default_rng(1).permutation(rows() + rows("other") + rows(environments=("again",)))
    found = read_foreign(write(tmp_path / "t.csv", list(shuffled), COLUMNS[::-1]), "walker", EXPECTED)
    assert list(found) == [("rooms", "A"), ("rooms", "B"), ("again", "B"), ("again", "A")]
    assert found["rooms", "B"].steps.tolist() == [[121, 122, 123], [131, 132, 133]]
    assert found["rooms", "B"].truncated.tolist() == [0, 0]


def test_numbers_and_an_index_as_other_programs_write_them(tmp_path):
    table = [{"": place, **row, "steps": f"{row['steps']}.0", "truncated": "False"} for place, row in enumerate(rows())]
    for columns in (("", *COLUMNS, "truncated"), (*COLUMNS, "truncated")):
        path = write(tmp_path / "t.csv", [{name: row[name] for name in columns} for row in table], columns)
        found = read_foreign(path, "walker", EXPECTED)
        assert found["rooms", "B"].steps.tolist() == [[121, 122, 123], [131, 132, 133]]
        assert found["rooms", "B"].truncated.tolist() == [0, 0]


@pytest.mark.parametrize(
    ("names", "numbers"),
    [
        (("42", "43"), {"42": 0, "43": 1}),
        (("run_10", "run_9"), {"run_9": 0, "run_10": 1}),
        (("1", "0.0"), {"0.0": 0, "1": 1}),
    ],
)
def test_seeds_may_have_any_names(tmp_path, names, numbers):
    path = write(tmp_path / "t.csv", [{**row, "seed": names[int(row["seed"])]} for row in rows()])
    found = read_foreign(path, "walker", EXPECTED)["rooms", "A"].steps[:, 0].tolist()
    assert found == [21 + 10 * names.index(name) for name in numbers]
    assert seeds_of(path, "walker", SEEDS) == numbers
    assert seeds_of(write(path, rows()), "walker", SEEDS) == {}


@pytest.mark.parametrize("separator", [";", "\t"])
def test_tables_of_spreadsheets_may_have_other_separators(tmp_path, separator):
    path = write(tmp_path / "t.csv", rows())
    path.write_text("\ufeff" + path.read_text().replace(",", separator), encoding="utf-8")
    assert read_foreign(path, "walker", EXPECTED)["rooms", "B"].steps.tolist() == [[121, 122, 123], [131, 132, 133]]


def test_truncated_episodes_are_counted(tmp_path):
    table = [{**row, "truncated": int(row["seed"] == 1 and row["episode"] < 3)} for row in rows()]
    table = [{**row, "steps": 1000} if row["truncated"] else row for row in table]
    found = read_foreign(write(tmp_path / "t.csv", table, (*COLUMNS, "truncated")), "walker", EXPECTED)
    assert found["rooms", "A"].truncated.tolist() == [0, 2]
    assert found["rooms", "A"].steps.tolist() == [[21, 22, 23], [1000, 1000, 33]]


@pytest.mark.parametrize("steps", [1, 999])
def test_an_episode_that_was_cut_off_too_early_is_refused(tmp_path, steps):
    """Even if all of them were: with fewer steps than the run's limit they would count as successes."""
    table = [{**row, "steps": steps, "truncated": 1} for row in rows()]
    assert refusal(write(tmp_path / "t.csv", table, (*COLUMNS, "truncated"))) == (
        f"line 2: steps '{steps}' is not allowed (task A of rooms); give 1000, the run's learning.max_steps, for a"
        " truncated episode"
    )


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"environment": "hall"}, "line 2: environment 'hall' is not allowed; give one of rooms, again"),
        ({"task": "C"}, "line 2: task 'C' is not allowed; give one of A, B"),
        ({"task": ""}, "line 2: task '' is not allowed; give one of A, B"),
        ({"seed": 2}, "method walker: has 3 seeds (0, 1, 2), and the run has 2; give as many"),
        ({"seed": " "}, "line 2: seed '' is not allowed; give a number or a name"),
        ({"episode": 0}, "line 2: episode '0' is not allowed; give a whole number from 1 to 3"),
        ({"steps": 5}, "line 2: steps '5' is not allowed (task A of rooms); give at least the shortest path, 8"),
        *[({"steps": value}, f"line 2: steps '{value}' is not allowed (task A of rooms); give a whole number from 1 to"
            " 1000") for value in ("21.5", "-30", "", "nan", "²1", "1001", "9" * 30, "1e3")],
        ({"seed": 1}, "method walker, environment rooms, task A: seed 1, episode 1 is given more than once, and 0 more;"
         " give 2 seeds, say 0 to 1, and episodes 1 to 3, each once"),
        ({"method": "x"}, "method walker, environment rooms, task A: seed 0, episode 1 is missing, and 0 more; give"),
    ],
)  # fmt: skip
def test_a_wrong_row_is_named(tmp_path, changes, message):
    table = rows()
    table[0] |= changes
    assert refusal(write(tmp_path / "t.csv", table)).startswith(message)


def test_a_missing_task_or_method_is_named(tmp_path):
    path = write(tmp_path / "t.csv", [row for row in rows() if row["task"] == "A"])
    assert refusal(path).startswith(
        "method walker, environment rooms, task B: seed 0, episode 1 is missing, and 5 more"
    )
    assert refusal(path, "runner") == "has no row of method runner; there are walker"


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "is no table (No columns to parse from file); correct it, or make one with"),
        (b"environment,method,task,seed,episode\n", "the columns"),
        (b"environment,method,task,seed,episode,steps,steps\n", "the columns"),
        (b"environment,method,task,seed,episode,steps,reward\n", "the columns"),
        (b"environment,method,task,,seed,episode,steps\n", "the columns"),
        (b"environment,method,task,seed,episode,steps\nrooms,walker\n", "line 2: seed '' is not allowed"),
        (b"environment,method,task,seed,episode,steps\na,b,c,1,1,1,1\n", "is no table (Error tokenizing data."
         " C error: Expected 6 fields in line 2, saw 7); correct it, or make"),
        (b'environment,method,task,seed,episode,steps\n"a', "is no table (Error tokenizing data. C"),
        (b"environment,method,task,seed,episode,steps\n\xff,b,c,1,1,1\n", "byte 44 is not UTF-8 text; save it"),
    ],
)  # fmt: skip
def test_what_is_no_such_table_is_refused(tmp_path, content, message):
    path = tmp_path / "t.csv"
    path.write_bytes(content)
    assert refusal(path).startswith(message)


def test_folders_pipes_and_absent_files_are_refused_at_once(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    assert refusal(tmp_path / "pipe") == "cannot be read (a pipe, not a file); give a CSV table"
    assert refusal(tmp_path) == "cannot be read (a folder, not a file); give a CSV table"
    assert refusal(tmp_path / "none.csv").startswith("cannot be read (No such file")


def test_the_configuration_checks_the_table_before_the_first_job(tmp_path):
    (tmp_path / "rooms.txt").write_text(ROOMS)
    path = write(tmp_path / "t.csv", rows())
    config = {
        "run": "own", "seeds": SEEDS, "methods": ["no_transfer"], "learning": {"episodes": EPISODES},
        "measures": {"window": 2}, "environments": {"rooms": {"map": str(tmp_path / "rooms.txt")}},
        "foreign_results": {"walker": {"file": str(path)}},
    }  # fmt: skip
    assert completed(config).foreign_results["walker"].label == "Walker"
    with pytest.raises(UserError, match="method walker, environment rooms, task A: seed 2, episode 1 is missing"):
        completed({**config, "seeds": 3})
    for taken in ("ptl", "no_transfer"):
        with pytest.raises(UserError, match=f"foreign_results.{taken}: is a method of this package"):
            completed({**config, "foreign_results": {taken: {"file": str(path)}}})
    with pytest.raises(UserError, match=r"foreign_results\.walker\.colour: 'red' is not allowed; give a colour such"):
        completed({**config, "foreign_results": {"walker": {"file": str(path), "colour": "red"}}})
