"""Result files: equal jobs give equal bytes, everything is read back, and damage is found and named."""

from __future__ import annotations

import json
import random
import subprocess
import sys

import msgspec
import numpy as np
import pytest
from damage import SEED, damages, rewrite
from lives import QUICK, ROOMS, job, live, write_life

from ptl.errors import UserError
from ptl.files import store
from ptl.files.atomic import atomic_path, write_text
from ptl.files.csv import format_number
from ptl.jobs.grow import Grow
from ptl.jobs.learn import skills_of, tasks_in

LIFE = live("ptl", 3)


@pytest.fixture
def learned(tmp_path):
    return write_life(tmp_path, "ptl", 3)


def test_everything_is_read_back(learned):
    result = store.read(learned, job("ptl", 3))
    assert result.job == job("ptl", 3) and result.job.settings == QUICK
    assert result.world.text == ROOMS.text and {"ptl", "numpy", "h5py"} == {*result.versions}
    for view, record in zip(tasks_in(result).values(), LIFE.records, strict=True):
        for name in ("q", "seen", "steps", "truncated"):
            np.testing.assert_array_equal(getattr(view, name), getattr(record, name))
        np.testing.assert_array_equal(view.original, record.discovery.original.product)
        np.testing.assert_array_equal(view.incremental, record.discovery.incremental.product)
        assert [view.selected_in(episode) for episode in range(20)] == record.selected
        assert (view.subgoal, view.diameter) == (record.update.subgoal, record.discovery.diameter)
        assert view.reason == record.update.reason and isinstance(view.novelty, float)
    for stored, skill in zip(skills_of(result.arrays), LIFE.library.skills, strict=True):
        np.testing.assert_array_equal(stored.policy, skill.policy)
        assert (stored.subgoal, stored.learned_after) == (skill.subgoal, skill.learned_after)


def test_equal_jobs_give_equal_bytes(tmp_path):
    first, second = write_life(tmp_path / "a", "ptl"), write_life(tmp_path / "b", "ptl")
    assert first.read_bytes() == second.read_bytes()
    assert write_life(tmp_path / "a", "ptl", 1).read_bytes() != first.read_bytes()
    assert store.digest_in(first) == job("ptl").digest
    assert store.digest_in(tmp_path / "none.h5") is None


def test_the_library_reads_a_file_of_any_kind_in_a_fresh_interpreter(learned):
    code = "import sys, ptl; print(ptl.read(sys.argv[1]).job.place)"
    command = [sys.executable, "-c", code, str(learned)]
    assert subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip() == job("ptl", 3).place


def test_a_growth_file_is_read_back(tmp_path):
    learn = job("ptl")
    shared = {"root_seed": 1, "parameters": learn.parameters, "maps": learn.maps, "code": learn.code}
    grow = Grow(**shared, environment="rooms", tasks=6, seed=0)
    store.write(tmp_path / "run_000.h5", grow, grow.run({"rooms": ROOMS}), {"rooms": ROOMS})
    sizes = store.read(tmp_path / "run_000.h5", grow).arrays["library_size"]
    assert sizes[0] == 0 and len(sizes) == 7 and sizes[-1] > 0
    with pytest.raises(UserError, match=r"was made with kind 'growth/2', not 'learning/2'"):
        store.read(tmp_path / "run_000.h5", learn)


def test_every_damage_is_found(learned, record_property):
    whole = learned.read_bytes()
    tried = 0
    for what, damaged in damages(whole, random.Random(SEED)):
        if damaged != whole:
            tried += 1
            learned.write_bytes(damaged)
            with pytest.raises(UserError, match=f"^{learned}: damaged.*; remove it") as caught:
                store.read(learned)
            assert "\n" not in str(caught.value), what
    record_property("damages tried, all found", tried)
    assert tried > 25


@pytest.mark.parametrize(
    ("name", "values", "says"),
    [
        ("tasks/A/steps", [1] * 20, "task A: an episode is shorter than the shortest path"),
        ("tasks/B/q", np.full((ROOMS.n_states, 4), 1.5), "task B: a value of Q is outside"),
        ("tasks/B/q", np.full((ROOMS.n_states, 4), np.nan), "tasks/B/q: has a value that is not finite"),
        ("tasks/A/selected_offsets", [0] * 21, "task A: the skills drawn do not fit"),
        ("library/policies", np.full((1, ROOMS.n_states), 3), "does not lead to the subgoal"),
        ("library/subgoals", [0], "its library is not made of the subgoals found|does not lead to the subgoal"),
    ],
)
def test_impossible_content_is_found_though_the_checksum_fits(learned, name, values, says):
    def change(file):
        stored = file[name]
        stored[...] = np.broadcast_to(np.asarray(values, dtype=stored.dtype)[: len(stored)], stored.shape)

    rewrite(learned, change)
    with pytest.raises(UserError, match=says):
        store.read(learned)


def test_a_map_other_than_that_of_the_job_is_found(learned):
    text = json.dumps({"rooms": ROOMS.text.replace("#..A#", "#.A.#")})
    rewrite(learned, lambda file: file.attrs.modify("maps", text))
    with pytest.raises(UserError, match="its map of rooms is not that of its job"):
        store.read(learned)


@pytest.mark.parametrize(
    ("wanted", "says"),
    [
        (
            job("ptl", 3, parameters=QUICK.replace(skills__patience=3.0)),
            "made with skills.patience 1.0, not 3.0; remove",
        ),
        (job("ptl", 4), "made with seed 3, not 4"),
        (msgspec.structs.replace(job("ptl", 3), slip=0.1), "made with slip 0.0, not 0.1; remove"),
        (job("no_transfer", 3), "made with method 'ptl', not 'no_transfer' \\(and 2 other differences\\)"),
        (msgspec.structs.replace(job("ptl", 3), code="0" * 16), "made with another version of the code"),
    ],
)
def test_a_file_of_another_job_is_refused(learned, wanted, says):
    with pytest.raises(UserError, match=f"^{learned}: was {says}"):
        store.read(learned, wanted)


def test_a_file_has_the_slip_of_its_world(tmp_path):
    slippery = msgspec.structs.replace(job("ptl"), slip=0.1)
    worlds = {"rooms": ROOMS.with_slip(0.1)}
    arrays = slippery.run(worlds)
    with pytest.raises(UserError, match=r"the slip of rooms, 0\.1, is not that of its job, 0\.0"):
        store.write(tmp_path / "a.h5", job("ptl"), arrays, worlds)
    store.write(tmp_path / "a.h5", slippery, arrays, worlds)
    assert store.read(tmp_path / "a.h5", slippery).world.slip == 0.1


def test_nothing_impossible_is_written(tmp_path):
    arrays = job("ptl").run({"rooms": ROOMS})
    with pytest.raises(UserError, match="is not written; tasks/A/q: is missing"):
        store.write(
            tmp_path / "a.h5", job("ptl"), {k: v for k, v in arrays.items() if k != "tasks/A/q"}, {"rooms": ROOMS}
        )
    assert not list(tmp_path.iterdir())


def test_other_files_are_named_as_such(tmp_path):
    with pytest.raises(UserError, match=r"none.h5: no such file; check the path"):
        store.read(tmp_path / "none.h5")
    (tmp_path / "notes.md").write_text("# Notes\n")
    with pytest.raises(UserError, match=r"notes.md: damaged, or no result file"):
        store.read(tmp_path / "notes.md")


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


def test_arrays_of_a_group_may_follow_those_of_groups_in_it(tmp_path):
    """A setting of the multiverse has arrays of its own beside those of its environments."""
    arrays = {"one/env1/ptl/measured": np.arange(3), "one/growth": np.arange(2), "one/env1/status": np.arange(1)}
    store.write_arrays(tmp_path / "nested.h5", arrays, {})
    back, _ = store.read_arrays(tmp_path / "nested.h5")
    assert set(back) == set(arrays)
    assert all(np.array_equal(back[name], values) for name, values in arrays.items())
