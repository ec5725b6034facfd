"""Results of other programs: what is read, and what is refused with one line before anything is learned."""

from __future__ import annotations

import csv
import os
from pathlib import Path

import numpy as np
import pytest
from projects import ROOMS

from ptl.errors import UserError
from ptl.files.configuration import completed
from ptl.files.foreign import COLUMNS, Expected, read_foreign
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


def test_truncated_episodes_are_counted_and_may_be_shorter_than_the_shortest_path(tmp_path):
    table = [{**row, "truncated": int(row["seed"] == 1 and row["episode"] < 3)} for row in rows()]
    table[3]["steps"] = 1
    found = read_foreign(write(tmp_path / "t.csv", table, (*COLUMNS, "truncated")), "walker", EXPECTED)
    assert found["rooms", "A"].truncated.tolist() == [0, 2]


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"environment": "hall"}, "line 2: environment 'hall' is not in this run; give one of rooms, again"),
        ({"task": "C"}, "line 2: 'C' is no task of rooms; give one of AB"),
        ({"task": ""}, "line 2: '' is no task of rooms"),
        ({"seed": 2}, "line 2: seed '2' is not allowed; give a whole number from 0 to 1"),
        ({"episode": 0}, "line 2: episode '0' is not allowed; give a whole number from 1 to 3"),
        ({"steps": 5}, "line 2: steps '5' is not allowed (environment rooms, task A, seed 0, episode 1); give a whole"
         " number from 8 to 1000"),
        *[({"steps": value}, f"line 2: steps '{value}' is not allowed") for value in ("21.0", "-30", "", "nan", "²1",
                                                                                        "1001", "9" * 30, "1e3")],
        ({"seed": 1}, "line 5: environment rooms, task A, seed 1, episode 1 is there twice; keep one of them"),
        ({"method": "x"}, "method walker: environment rooms, task A, seed 0, episode 1 is missing, and 0 more of this"
         " task; the run has seeds 0 to 1 and episodes 1 to 3"),
    ],
)  # fmt: skip
def test_a_wrong_row_is_named(tmp_path, changes, message):
    table = rows()
    table[0] |= changes
    assert refusal(write(tmp_path / "t.csv", table)).startswith(message)


def test_a_missing_task_or_method_is_named(tmp_path):
    path = write(tmp_path / "t.csv", [row for row in rows() if row["task"] == "A"])
    assert refusal(path) == "method walker has no task B of environment rooms; add it"
    assert refusal(path, "runner") == "has no row of method runner; there are walker"


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "the columns '' are not allowed; give environment,method,task,seed,episode,steps"),
        (b"environment,method,task,seed,episode\n", "the columns"),
        (b"environment,method,task,seed,episode,steps,steps\n", "the columns"),
        (b"environment,method,task,seed,episode,steps,reward\n", "the columns"),
        (b"environment,method,task,seed,episode,steps\na,b\n", "line 2: 2 cells where the header has 6"),
        (b'environment,method,task,seed,episode,steps\n"a', "line 2: is not CSV"),
        (b"environment,method,task,seed,episode,steps\n\xff,b,c,1,1,1\n", "is not UTF-8 text"),
        (b"environment,method,task,seed,episode,steps\n" + b"a" * 200_000, "line 2: is not CSV"),
    ],
)
def test_what_is_no_such_table_is_refused(tmp_path, content, message):
    path = tmp_path / "t.csv"
    path.write_bytes(content)
    assert refusal(path).startswith(message)


def test_folders_pipes_and_absent_files_are_refused_at_once(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    assert refusal(tmp_path / "pipe") == "is no file; give a CSV table"
    assert refusal(tmp_path) == "is no file; give a CSV table"
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
    with pytest.raises(UserError, match="method walker: environment rooms, task A, seed 2, episode 1 is missing"):
        completed({**config, "seeds": 3})
    for taken in ("ptl", "no_transfer"):
        with pytest.raises(UserError, match=f"foreign_results.{taken}: is a method of this package"):
            completed({**config, "foreign_results": {taken: {"file": str(path)}}})
    with pytest.raises(UserError, match=r"foreign_results\.walker\.colour: 'red' is not allowed; give a colour such"):
        completed({**config, "foreign_results": {"walker": {"file": str(path), "colour": "red"}}})
