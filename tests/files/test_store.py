"""HDF5 files: equal runs give equal bytes, everything is read back, and damage is found and named."""

from __future__ import annotations

import re
from pathlib import Path

import h5py
import numpy as np
import pytest
from damage import rewrite
from lives import QUICK, ROOMS, live, origin

from ptl.config import Parameters
from ptl.errors import UserError
from ptl.files.atomic import atomic_path, write_text
from ptl.files.csv import format_number
from ptl.files.hdf5 import read_file
from ptl.files.results import GROWTH, open_learning, open_result, write_growth, write_learning
from ptl.files.verification import faults_of
from ptl.learning.growth import grow_library

LIFE = live("ptl", 3)


def write(path: Path, seed: int = 3) -> Path:
    write_learning(path, LIFE, ROOMS, origin("ptl", seed))
    return path


@pytest.fixture
def learned(tmp_path) -> Path:
    return write(tmp_path / "learning/rooms/ptl/seed_003.h5")


def test_everything_is_read_back(learned):
    with open_learning(learned) as result:
        assert (result.environment, result.method, result.seed, result.root_seed) == ("rooms", "ptl", 3, 1)
        assert Parameters.from_dict(result.parameters) == QUICK
        assert result.world.text == ROOMS.text
        assert list(result.tasks) == ["A", "B"]
        for view, record in zip(result.tasks.values(), LIFE.records, strict=True):
            for name in ("q", "seen", "steps", "truncated"):
                np.testing.assert_array_equal(getattr(view, name), getattr(record, name))
            np.testing.assert_array_equal(view.original, record.discovery.original.product)
            np.testing.assert_array_equal(view.incremental, record.discovery.incremental.product)
            assert [view.selected_in(episode) for episode in range(20)] == record.selected
            assert (view.subgoal, view.diameter) == (record.update.subgoal, record.discovery.diameter)
        for stored, skill in zip(result.library, LIFE.library.skills, strict=True):
            np.testing.assert_array_equal(stored.policy, skill.policy)
            assert (stored.subgoal, stored.learned_after) == (skill.subgoal, skill.learned_after)
        with pytest.raises(AttributeError, match="holds no 'colour'"):
            _ = result.tasks["A"].colour


def test_equal_lives_give_equal_bytes(tmp_path):
    first, second = write(tmp_path / "a.h5"), write(tmp_path / "b.h5")
    assert first.read_bytes() == second.read_bytes()
    assert write(tmp_path / "c.h5", seed=4).read_bytes() != first.read_bytes()


def test_a_good_file_has_no_faults(learned):
    assert faults_of(learned) == []


def test_growth_file(tmp_path):
    life = grow_library(ROOMS, 6, QUICK, 1, "rooms", 0)
    path = tmp_path / "growth/run_000.h5"
    write_growth(path, life, ROOMS, origin("ptl", 0, module="growth"))
    assert faults_of(path) == []
    with open_result(path, GROWTH) as result:
        sizes = result.file["library_size"][()]
    assert sizes[0] == 0 and sizes[-1] == len(life.library) and len(sizes) == 7
    with pytest.raises(UserError, match=r"is not a ptl-learning/1 file .*belongs to no run"), open_learning(path):
        pass


def test_numbers_of_a_task_stay_after_the_file_is_closed(learned):
    with open_learning(learned) as file:
        view = file.tasks["A"]
    assert view.goal == ROOMS.goal("A") and view.reason
    assert isinstance(view.novelty, float) and isinstance(view.diameter, int)


def _set(name: str, index, value):
    def change(file: h5py.File) -> None:
        file[name][index] = value

    return change


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (_set("tasks/A/steps", 0, 1), "task A: an episode is shorter than the shortest path"),
        (_set("tasks/B/q", (0, 0), 1.5), r"task B: a value of Q .*\[0, 1\]"),
        (_set("tasks/B/q", (0, 0), np.nan), r"/tasks/B/q: holds a value that is not finite"),
        (_set("tasks/B/selected", 0, 7), "task B: a skill was drawn that did not exist yet"),
        (_set("tasks/A/selected_offsets", -1, 3), "task A: the skills drawn do not fit"),
        (_set("library/policies", (0, slice(None)), 3), "does not lead to the subgoal"),
        (_set("library/subgoals", 0, 0), "the library does not hold the subgoal found"),
        (lambda file: file.attrs.modify("code", "0" * 16), "made by another version of the code"),
        (lambda file: file.attrs.modify("seed", 9), "holds the job rooms/ptl/seed_009.h5"),
    ],
)
def test_impossible_content_is_found_though_the_checksum_fits(learned, change, says):
    rewrite(learned, change)
    faults = faults_of(learned)
    assert any(re.search(says, fault) for fault in faults), faults
    assert all("\n" not in fault and "belongs to no run of this folder" in fault for fault in faults)


def test_missing_file(tmp_path):
    [fault] = faults_of(tmp_path / "none.h5")
    assert fault.endswith("no such file; check the path")


@pytest.mark.parametrize(("name", "kind"), [("README.md", "text/markdown"), ("reports/tiny/metrics.csv", "text/csv")])
def test_files_of_other_kinds_are_not_taken_for_damage(tmp_path, monkeypatch, name, kind):
    monkeypatch.chdir(tmp_path)
    for path, text in (("config/config.yaml", "run: tiny\n"), (name, "environment,task\n")):
        Path(path).parent.mkdir(exist_ok=True, parents=True)
        Path(path).write_text(text)
    with pytest.raises(UserError, match=f"^{name}: is {kind}, no result file; name a file that ends in .h5$"):
        read_file(name)


def test_errors_of_the_reader_are_not_taken_for_damage(learned):
    with pytest.raises(ValueError, match="mine"), open_learning(learned):
        raise ValueError("mine")


def test_interrupted_write_leaves_the_old_file_and_no_litter(tmp_path):
    path = tmp_path / "product.txt"
    write_text(path, "old")
    with pytest.raises(RuntimeError), atomic_path(path) as temporary:
        temporary.write_text("half")
        raise RuntimeError
    assert path.read_text() == "old" and list(tmp_path.iterdir()) == [path]


def test_unwritable_folder_is_a_user_error(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(UserError, match="cannot be written"):
        write_text(tmp_path / "file" / "product.txt", "x")


@pytest.mark.parametrize(
    ("value", "text"),
    [(1132769.4, "1132770"), (0.1234567, "0.123457"), (3.0, "3"), (1e-9, "1e-09"), (123456.7, "123457")],
)
def test_numbers_have_six_digits_and_no_positive_exponent(value, text):
    assert format_number(value) == text
