"""Files that break their declaration in every way that it can be broken: every reader refuses them in one line."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterator
from dataclasses import asdict
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import h5py
import numpy as np
import pytest
from damage import rewrite
from lives import QUICK, ROOMS, ROOT_SEED, live, origin, write_life
from projects import ROOT

from ptl.cli.inspect import command as inspect
from ptl.cli.survey import merge
from ptl.errors import UserError
from ptl.files.arrays import read_arrays, write_arrays
from ptl.files.hdf5 import read_file, sealed
from ptl.files.provenance import code_digest
from ptl.files.question import lives_code
from ptl.files.results import open_learning, write_frequencies, write_growth, write_learning
from ptl.files.schema import (
    FIT,
    FREQUENCIES,
    GAIN,
    GROWTH,
    KINDS,
    LEARNING,
    LIVES,
    SETTING,
    STEPS,
    Array,
    Attribute,
    Group,
)
from ptl.files.schema_docs import filled
from ptl.files.verification import faults_of
from ptl.learning.growth import grow_library
from ptl.learning.lives import learn_lives
from ptl.learning.survey import subgoal_frequencies
from ptl.measures.growth import library_sizes
from ptl.measures.measures import measure_files
from ptl.report.explorer.data import collect
from ptl.report.figures import discovery, frequencies
from ptl.report.figures.steps import open_steps
from studies.beyond.collect import per_task
from studies.beyond.running import Cell, run_cell
from studies.fit.search import read_by
from studies.fv_check.experiment import read_gains
from studies.robustness.running import run_setting
from studies.robustness.verdicts import load_setting

Change = Callable[[h5py.File], None]


# -- one good file of each kind -----------------------------------------------------------------------------------


def write_setting(path: Path) -> None:
    map_file = path.parent.parent / "rooms.txt"
    map_file.write_text(ROOMS.text)
    entry = {"map": str(map_file), "tasks": "AB", "changes": {}}
    run_setting(
        {
            "setting": path.stem, "group": "reference", "changes": {}, "root_seed": 1, "seeds": 2, "step_budget": 10**6,
            "environments": {"rooms": entry}, "methods": ["no_transfer", "ptl"], "parameters": QUICK.to_dict(),
            "growth": {"environment": "rooms", "runs": 1, "tasks": 3},
        },
        path,
    )  # fmt: skip


def write_lives(path: Path) -> None:
    map_file = path.parents[3] / "rooms.txt"
    map_file.write_text(ROOMS.text)
    cell = Cell("rooms", 0, "article", [str(map_file)], 2, "ptl", tasks="AB")
    job = {"cell": asdict(cell), "maps": "", "root_seed": 1, "population": "", "parameters": QUICK.to_dict()}
    run_cell(job, path, lives_code("ptl.methods.ptl"))


@pytest.fixture(scope="module")
def good(tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    """Content of one file of each kind, named as in a run."""
    folder = tmp_path_factory.mktemp("good")
    paths = {kind: folder / name for kind, name in NAMES.items()}
    write_life(folder / "learning", "ptl", tasks="A")
    life = grow_library(ROOMS, 6, QUICK, ROOT_SEED, "rooms", 0)
    write_growth(paths[GROWTH], life, ROOMS, origin("ptl", 0, module="growth"))
    counts = subgoal_frequencies(
        ROOMS, np.arange(ROOMS.n_states), range(ROOMS.n_states), 3, QUICK.learning, ROOT_SEED, "rooms"
    )
    whence = {"environment": "rooms", "trajectories": 3, "starts": ROOMS.n_states, "batch": 0, "batches": 1,
              "root_seed": ROOT_SEED, "parameters": QUICK.to_dict(),
              "code": code_digest("ptl.learning.survey")}  # fmt: skip
    write_frequencies(paths[FREQUENCIES], counts, ROOMS, whence)
    steps = np.full((2, 5), 9)
    write_arrays(paths[STEPS], STEPS, {"rooms/ptl/A": steps, "rooms/no_transfer/A": steps}, {"seeds": np.arange(2)})
    write_arrays(
        paths[GAIN],
        GAIN,
        {"seeds": np.arange(2), "gain": np.full((2, 5), 0.5), "policy_quality": np.full((2, 3), 0.5)},
        {"arm": "library_234", "root_seed": 1, "library_trials": 5, "parameters": QUICK.to_dict(), "map": ROOMS.text,
         "code": "0" * 16},
    )  # fmt: skip
    write_setting(paths[SETTING])
    lives = {f"lives/{name}": values for name, values in learn_lives(ROOMS, "AB", "ptl", QUICK, 1, range(2)).items()}
    unit = {"map": ROOMS.text, "tasks": "AB", "method": "ptl", "parameters": read_by("ptl", QUICK), "seeds": 2}
    write_arrays(paths[FIT], FIT, lives, {"unit": unit, "setting": "0123abcd"})
    write_lives(paths[LIVES])
    return {kind: path.read_bytes() for kind, path in paths.items()}


NAMES = {
    LEARNING: "learning/rooms/ptl/seed_000.h5",
    GROWTH: "growth/run_000.h5",
    FREQUENCIES: "subgoal_frequencies/rooms/batch_0.h5",
    STEPS: "steps.h5",
    GAIN: "fernandez_veloso/library_234.h5",
    SETTING: "robustness/reference_1.h5",
    FIT: "fit/0123abcd.h5",
    LIVES: "lives/rooms_0_article/ptl/rooms.h5",
}

GROUPS = SimpleNamespace(
    measures=SimpleNamespace(window=5, threshold_factor=1.5),
    statistics=SimpleNamespace(confidence=0.95, resamples=100),
    growth=SimpleNamespace(breakpoint=2),
)

READERS: dict[str, list[Callable[[Path], Any]]] = {
    LEARNING: [
        lambda path: measure_files([path], 5, 1.5),
        lambda path: collect([path], window=5),
        lambda path: discovery.collect([path], ["A"]),
    ],
    GROWTH: [lambda path: library_sizes([path])],
    FREQUENCIES: [
        lambda path: merge.callback((str(path),), str(path.with_name("merged.h5"))),
        lambda path: frequencies.read([path]),
    ],
    STEPS: [lambda path: open_steps(path).__enter__().steps("rooms", "ptl", "A")],
    GAIN: [lambda path: read_gains([path])],
    SETTING: [lambda path: load_setting(path, GROUPS)],
    FIT: [lambda path: read_arrays(path, FIT)],
    LIVES: [lambda path: per_task([path])],
}
"""What reads each kind of file, besides `ptl inspect` and `ptl verify`."""


def written(folder: Path, kind: str, content: bytes) -> Path:
    path = folder / NAMES[kind]
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(content)
    return path


# -- every way to break a declaration -----------------------------------------------------------------------------


def replaced(where: str, name: str, value: Any, **options: Any) -> Change:
    def change(file: h5py.File) -> None:
        del file[where][name]
        file[where].create_dataset(name, data=value, **options)

    return change


def attribute(where: str, name: str, value: Any) -> Change:
    def change(file: h5py.File) -> None:
        del file[where].attrs[name]
        if value is not None:
            file[where].attrs[name] = value

    return change


def linked(where: str, name: str, link: Any) -> Change:
    def change(file: h5py.File) -> None:
        if name in file[where]:
            del file[where][name]
        file[where][name] = file["/"] if isinstance(link, str) else link

    return change


def bad_attributes(where: str, item: Attribute, now: Any) -> Iterator[tuple[str, Change]]:
    def bad(what: str, value: Any) -> tuple[str, Change]:
        return f"{where}: {item.name} {what}", attribute(where, item.name, value)

    yield bad("missing", None)
    yield bad("twice", [now, now] if not item.shape else [[1, 2], [3, 4]])
    yield bad("huge", np.zeros(5000, dtype="int8"))
    if item.dtype:
        yield bad("a text", "1")
        yield bad("of a smaller type", np.asarray(now).astype("int16"))
        for limit, beyond in ((item.low, -1), (item.high, 1)):
            if limit is not None:
                value = 10**9 if isinstance(limit, str) else limit + beyond
                yield bad("out of range", np.full(np.shape(now), value, dtype=item.dtype)[()])
        if item.dtype == "float64":
            yield from (bad(f"{value}", value) for value in (np.nan, np.inf, -np.inf))
        return
    yield bad("a number", 1)
    yield bad("bytes of fixed length", np.bytes_(b"x"))
    yield bad("with a control character", f"{now}\x1b[2J")
    if item.content == "json":
        deep = "[" * 100_000 + "]" * 100_000
        texts = ("", "{", "[]", "1", '{"a": NaN}', '{"a": Infinity}', '{"a": 1e999}', '{"a": 1, "a": 1}', deep,
                 f'{{"a": {deep}}}', '{"a": "\\u001b"}', f'{{"a": {"9" * 5000}}}')  # fmt: skip
        yield from (bad(f"JSON {text[:20]}", text) for text in texts)
        if item.keys and "" in item.keys:
            yield bad("with a value of another type", '{"a": 1}')
        for key in set(item.keys or ()) - {""}:
            yield bad(f"without {key}", json.dumps({k: v for k, v in json.loads(now).items() if k != key}))
    elif item.content == "map":
        yield from (bad(f"no map {text!r}", text) for text in ("", "#", "I.\n", "I.A\n..\n", "IXA?\n"))
    elif item.content != "text":
        yield from (bad(f"{text!r}", text) for text in ("", "../x", "A B", "<b>", "a/b"))


def bad_arrays(where: str, item: Array, now: np.ndarray, fifo: str) -> Iterator[tuple[str, Change]]:
    name = item.name
    place = f"{where}/{name}"

    def bad(what: str, value: Any, **options: Any) -> tuple[str, Change]:
        return f"{place} {what}", replaced(where, name, value, **options)

    def huge(file: h5py.File) -> None:
        del file[where][name]
        shape = (2**40,) * max(now.ndim, 1)
        file[where].create_dataset(name, shape=shape[:1] + now.shape[1:], dtype=now.dtype, chunks=True)

    def hollow(file: h5py.File) -> None:
        """Of the right shape, with nothing stored."""
        del file[where][name]
        file[where].create_dataset(name, shape=now.shape, dtype=now.dtype, chunks=now.shape if now.size else None)

    def external(file: h5py.File) -> None:
        del file[where][name]
        file[where].create_dataset(name, shape=now.shape, dtype=now.dtype, external=[("/etc/passwd", 0, 10**6)])

    def virtual(file: h5py.File) -> None:
        del file[where][name]
        layout = h5py.VirtualLayout(shape=now.shape, dtype=now.dtype)
        layout[...] = h5py.VirtualSource(fifo, "x", shape=now.shape)
        file[where].create_virtual_dataset(name, layout)

    def decorated(file: h5py.File) -> None:
        file[place].attrs["x"] = 1

    def second_name(file: h5py.File) -> None:
        file[f"{where}/other"] = file[place]

    yield f"{place} huge", huge
    yield f"{place} with an attribute", decorated
    yield f"{place} with a second name", second_name
    if now.size:
        yield f"{place} virtual", virtual
        if now.ndim:
            yield f"{place} hollow", hollow
            yield f"{place} external", external
            yield bad("with a checksum filter", now, fletcher32=True)
            yield bad("with LZF", now, compression="lzf")
    types = {"S": "float64", "f": "int64"}
    yield bad("of another type", np.zeros(now.shape, dtype=types.get(now.dtype.kind, "float32")))
    yield bad("of one more dimension", now[None])
    if not any(isinstance(part, str) and part in FREE for part in item.shape):
        yield bad("of another shape", np.concatenate([now, now[:1]]) if now.ndim else np.stack([now] * 2))
    if now.size and now.dtype.kind in "iuf":
        for limit, beyond in ((item.low, -1), (item.high, 1)):
            if limit is not None and not (now.dtype.kind == "u" and beyond < 0):
                value = min(10**9, np.iinfo(now.dtype).max) if isinstance(limit, str) else int(limit) + beyond
                yield bad("out of range", np.full(now.shape, value, dtype=now.dtype))
    if now.dtype.kind == "f":
        yield from (bad(f"{value}", np.full(now.shape, value)) for value in (np.nan, np.inf, -np.inf))


FREE = {"m", "k", "r", "g", "t", "p"}
"""Sizes that only the file itself knows."""


def missing(place: str) -> Change:
    def change(file: h5py.File) -> None:
        del file[place]

    return change


def bad_members(where: str, name: str, fifo: str) -> Iterator[tuple[str, Change]]:
    """Of a group or array that is there."""
    place = f"{where}/{name}"
    yield f"{place} a soft link", linked(where, name, h5py.SoftLink("/nowhere"))
    yield f"{place} a soft link to itself", linked(where, name, h5py.SoftLink(place))
    yield f"{place} an external link", linked(where, name, h5py.ExternalLink(fifo, "/x"))
    yield f"{place} a loop", linked(where, name, "loop")


def bad_files(file: h5py.File, declared: Group, where: str, fifo: str) -> Iterator[tuple[str, Change]]:
    """Yield the ways to break a group and all in it; ``file`` is a good one."""
    yield f"{where} with more in it", linked(where, "more\x1b[2J", np.zeros(3))
    yield f"{where} with a link in it", linked(where, "more", h5py.ExternalLink(fifo, "/x"))
    yield f"{where} with one more attribute", lambda file: file[where].attrs.create("mo\x1bre", 1)
    for item in declared.attributes:
        yield from bad_attributes(where, item, file[where].attrs[item.name])
    for name, found in file[where].items():
        place = f"{where}/{name}"
        member = declared.member(name)
        yield from bad_members(where, name, fifo)
        if isinstance(member, Array):
            yield from bad_arrays(where, Array(name, *list(vars(member).values())[1:]), found[()], fifo)
            yield f"{place} a group", lambda file, where=where, name=name: (missing(f"{where}/{name}")(file),
                                                                          file[where].create_group(name))  # fmt: skip
        else:
            assert isinstance(member, Group)
            yield f"{place} an array", replaced(where, name, np.zeros(3))
            yield from bad_files(file, member, place, fifo)
        if name != "rooms" and member is not None and (not member.optional or isinstance(member, Array)):
            last = member.name.startswith("<") and len(file[where]) > 1
            if not last:
                yield f"{place} missing", missing(place)


@pytest.mark.parametrize("kind", KINDS)
def test_whatever_breaks_the_declaration_is_refused_by_all_that_reads(
    kind: str, good: dict[str, bytes], tmp_path: Path, record_property: Callable[[str, int], None]
) -> None:
    os.mkfifo(tmp_path / "pipe")
    path = written(tmp_path, kind, good[kind])
    inspect.callback((path,))
    assert not [fault for fault in faults_of(path, current_code=False) if "code" not in fault]
    for reader in READERS[kind]:
        reader(path)
    with h5py.File(path) as file:
        broken = dict(bad_files(file, KINDS[kind].root, "/", str(tmp_path / "pipe")))
        changes = list(broken.items())
    readers = [lambda path: inspect.callback((path,)), *READERS[kind]]
    for what, change in changes:
        path.write_bytes(good[kind])
        rewrite(path, change)
        [fault] = faults_of(path, current_code=False) or [f"not found: {what}"]
        assert fault.startswith(f"{path}: ") and fault.isprintable(), f"{what}: {fault}"
        for reader in readers:
            with pytest.raises(UserError) as caught:
                reader(path)
                pytest.fail(f"{what} was read")
            assert str(caught.value).isprintable()
    record_property(f"ways to break a {kind} file, all refused", len(changes))
    assert len(changes) > 40


# -- what fits its declaration and cannot be ----------------------------------------------------------------------


def value(place: str, index: Any, number: Any) -> Change:
    def change(file: h5py.File) -> None:
        file[place][index] = number

    return change


def both(*changes: Change) -> Change:
    def change(file: h5py.File) -> None:
        for one in changes:
            one(file)

    return change


def of_job(name: str, new: Any, of: str = "job") -> Change:
    """Change a value of the job by the keys that lead to it, with slashes between them."""

    def change(file: h5py.File) -> None:
        job = json.loads(file.attrs[of])
        *parts, last = name.split("/")
        inner = job
        for part in parts:
            inner = inner[part]
        inner[last] = new
        file.attrs[of] = json.dumps(job)

    return change


def at_root(name: str, new: Any) -> Change:
    return attribute("/", name, new)


def no_lives(group: h5py.Group) -> None:
    for name, values in {name: item[:0] for name, item in group.items()}.items():
        del group[name]
        group[name] = values


IMPOSSIBLE: list[tuple[str, Change, str]] = [
    (LEARNING, attribute("/tasks/A", "start", 1), "task A: does not lead from the start of the map to its goal A"),
    (LEARNING, attribute("/tasks/A", "goal", 0), "task A: does not lead from the start of the map to its goal A"),
    (LEARNING, lambda file: file.move("/tasks/A", "/tasks/B"), "task B: does not lead"),
    (LEARNING, lambda file: file.move("/tasks/A", "/tasks/Z"), "task Z: does not lead"),
    (LEARNING, value("/tasks/A/steps", 3, 2**62), "an episode is longer than learning.max_steps"),
    (LEARNING, value("/tasks/A/truncated", 3, True), "a truncated episode is shorter than learning.max_steps"),
    (LEARNING, both(at_root("method", "own"), value("/tasks/A/steps", 3, 2**62)), "longer than learning.max_steps"),
    (LEARNING, attribute("/tasks/A", "novelty", 1e9), "its novelty or diameter"),
    (LEARNING, attribute("/tasks/A", "diameter", ROOMS.n_states), "its novelty or diameter"),
    (LEARNING, attribute("/tasks/A", "diameter", 0), "has a new subgoal though its diameter is 0"),
    (GROWTH, lambda file: file["goals"].write_direct(file["starts"][()]), "no way from its start to another state"),
    (GROWTH, value("/total_steps", 2, 1), "fewer steps than its shortest path"),
    (GROWTH, value("/total_steps", 2, 2**62), "more steps than learning.max_steps"),
    (FREQUENCIES, value("/counts", slice(2), 2**62), "its counts do not add up"),
    (FREQUENCIES, both(value("/pairs", (), 0), value("/unresolved", (), 0), value("/counts", ..., 0)),
     "it has 0 pairs of start and goal where"),
    (FREQUENCIES, at_root("starts", ROOMS.n_states - 1), "pairs of start and goal where"),
    (FREQUENCIES, at_root("starts", ROOMS.n_states + 1), "more starts than the map has states"),
    (FREQUENCIES, at_root("batches", 2), "pairs of start and goal where"),
    (FREQUENCIES, at_root("batch", 1), "its batch is none of its batches"),
    (STEPS, value("/rooms/ptl/A", (0, 0), 0), "rooms/ptl/A: an episode has no steps"),
    (STEPS, at_root("seeds", [1, 1]), "holds no seeds, or one twice"),
    (GAIN, value("/seeds", ..., 1), "holds no seeds, or one twice"),
    (GAIN, both(*[replaced("/", name, np.zeros(shape, dtype=kind)) for name, shape, kind in
                  (("seeds", 0, "int64"), ("gain", (0, 5), float), ("policy_quality", (0, 3), float))]),
     "holds no seeds, or one twice"),
    (GAIN, replaced("/", "gain", np.zeros((2, 0))), "holds no trials"),
    (SETTING, value("/rooms/ptl/steps", (0, 0, 0), 0), "rooms/ptl: an episode is shorter than the shortest path"),
    (SETTING, value("/rooms/ptl/steps", (0, 0, 0), 2**62), "rooms/ptl: an episode is longer than"),
    (SETTING, value("/rooms/ptl/truncated", (0, 0), 1), "its truncated episodes are not those"),
    (SETTING, value("/rooms/ptl/subgoal", (0, 0), ROOMS.n_states), "rooms/ptl/subgoal holds a state that is not there"),
    (SETTING, value("/rooms/ptl/novelty", (0, 0), 1e9), "its novelty is longer"),
    (SETTING, value("/rooms/ptl/seeds", ..., 0), "rooms/ptl: its seeds are not 0, 1, ..."),
    (SETTING, value("/growth/library_size", (0, 1), 3), "growth: a library does not grow"),
    (SETTING, replaced("/growth", "library_size", np.zeros((2, 4), dtype=int)), "growth: does not have 1 lives"),
    (SETTING, missing("/rooms/ptl"), "lacks some of its job's lives"),
    (SETTING, missing("/growth"), "lacks some of its job's lives"),
    (SETTING, of_job("seeds", 3), "has not all seeds though"),
    (SETTING, of_job("setting", "other"), "its job is that of another setting"),
    (SETTING, of_job("methods", ["ptl"]), "holds rooms/no_transfer, which its job does not name"),
    (SETTING, of_job("environments/rooms/tasks", "AC"), "does not have the tasks AC"),
    (SETTING, of_job("environments/more", {"tasks": "A"}), "its maps are not those of its job's environments"),
    (SETTING, of_job("parameters/learning/episodes", 19), "with 19 episodes each"),
    (SETTING, of_job("parameters/learning/episodes", -1), "its job or a map cannot be right"),
    (SETTING, of_job("parameters/learning", 1), "its job or a map cannot be right"),
    (SETTING, of_job("growth/tasks", -1), "its job or a map cannot be right"),
    (SETTING, of_job("environments/rooms/tasks", "\u202eA"), "its job or a map cannot be right"),
    (SETTING, lambda file: no_lives(file["/rooms/ptl"]), "rooms/ptl: holds no lives"),
    (SETTING, of_job("growth", None), "its job or a map cannot be right"),
    (SETTING, of_job("rooms", "no map", "maps"), "its job or a map cannot be right"),
    (FIT, value("/lives/steps", (0, 0, 0), 0), "lives: an episode is shorter than the shortest path"),
    (FIT, value("/lives/seeds", ..., 1), "lives: its seeds are not 0, 1, ..."),
    (FIT, of_job("map", "no map", "unit"), "its unit cannot be right"),
    (FIT, of_job("parameters", {"x\n": {"y": 1}}, "unit"), "its unit cannot be right"),
    (FIT, of_job("parameters", {"learning.alpha.x": 1}, "unit"), "its unit cannot be right"),
    (FIT, lambda file: no_lives(file["lives"]), "lives: holds no lives"),
    (FIT, of_job("seeds", None, "unit"), "its unit cannot be right"),
    (FIT, lambda file: file.create_dataset("growth/library_size", data=[[0, 1]]), "its unit cannot be right"),
    (LIVES, of_job("cell", {}), "its job cannot be right"),
    (LIVES, of_job("cell/maps", []), "does not hold the lives of its job: 0 maps"),
    (LIVES, of_job("cell/seeds", 3), "does not hold the lives of its job: 1 maps, 3 lives"),
    (LIVES, of_job("cell/tasks", "A"), "does not hold the lives of its job: 1 maps, 2 lives, 1 tasks"),
    (LIVES, of_job("parameters/learning/episodes", -1), "its job cannot be right"),
    (LIVES, value("/steps", (0, 0, 0), 1), "a task took fewer steps than its shortest path"),
    (LIVES, value("/steps", (0, 0, 0), 2**62), "a task took more steps than learning.max_steps"),
    (LIVES, value("/first", (0, 0, 0), 0), "a first episode is shorter than the shortest path"),
    (LIVES, value("/first", (0, 0, 0), 10**7), "a first episode is shorter than the shortest path, or longer"),
    (LIVES, value("/truncated", (0, 0, 0), 21), "a number of truncated episodes that cannot be"),
    (LIVES, value("/truncated", (0, 0, 0), 1), "a task took fewer steps"),
    (LIVES, value("/shortest", (0, 0), 10**6), "a shortest path is longer than any path without loops"),
    (LIVES, both(of_job("parameters/learning/max_steps", 1), value("/first", ..., 1), value("/steps", ..., 20),
                 value("/truncated", ..., 0)), "a number of truncated episodes that cannot be"),
]  # fmt: skip


@pytest.mark.parametrize(("kind", "change", "says"), IMPOSSIBLE)
def test_what_cannot_be_is_found_and_nothing_of_it_shown(
    kind: str, change: Change, says: str, good: dict[str, bytes], tmp_path: Path, capsys: pytest.CaptureFixture
) -> None:
    path = written(tmp_path, kind, good[kind])
    rewrite(path, change)
    [fault] = faults_of(path, current_code=False)
    assert fault.startswith(f"{path}: ") and says in fault and fault.isprintable()
    with pytest.raises(UserError) as caught:
        inspect.callback((path,))
    assert says in str(caught.value) and capsys.readouterr().out == ""


def test_impossible_settings_are_not_read(good: dict[str, bytes], tmp_path: Path) -> None:
    path = written(tmp_path, SETTING, good[SETTING])
    rewrite(path, value("/rooms/ptl/steps", (0, 0, 0), 0))
    with pytest.raises(UserError, match="shorter than the shortest path"):
        load_setting(path, GROUPS)


def test_the_page_on_formats_is_made_from_the_declarations() -> None:
    page = (ROOT / "docs/file-format.md").read_text(encoding="utf-8")
    assert all(f"<!-- schema: {kind}, begin -->" in page for kind in KINDS)
    assert filled(page) == page, "run 'make docs'"


# -- whatever else lies in a file's place -------------------------------------------------------------------------


def test_no_pipe_folder_or_device_is_waited_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.h5")
    (tmp_path / "folder.h5").mkdir()
    (tmp_path / "zero.h5").symlink_to("/dev/zero")
    (tmp_path / "endless.h5").symlink_to("/proc/kmsg")
    (tmp_path / "loop.h5").symlink_to("loop.h5")
    for name in ("pipe", "folder", "zero", "endless", "loop", "none"):
        for read in (lambda path: read_file(path, *KINDS), lambda path: inspect.callback((path,))):
            with pytest.raises(UserError, match=rf"{name}\.h5: "):
                read(tmp_path / f"{name}.h5")
        assert len(faults_of(tmp_path / f"{name}.h5")) == 1


def test_other_files_are_named_as_what_they_are(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for name, content in {"README.md": b"# Read me\n" * 30, "metrics.csv": b"a,b\n1,2\n", "empty": b""}.items():
        Path(name).write_bytes(content)
        with pytest.raises(UserError, match=r"no result file|not a result file") as caught:
            inspect.callback((Path(name),))
        assert "remove" not in str(caught.value) and "snakemake" not in str(caught.value)


def test_an_hdf5_file_of_another_program_is_named_so(tmp_path: Path) -> None:
    path = tmp_path / "other.h5"
    with h5py.File(path, "w") as file:
        file["x"] = 1
    path.write_bytes(sealed(path.read_bytes()))
    with pytest.raises(UserError, match=r"is not a result file \(no attribute 'format'\)"):
        read_file(path, *KINDS)


def test_steps_of_a_run_can_be_inspected(good: dict[str, bytes], tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    inspect.callback((written(tmp_path, STEPS, good[STEPS]),))
    assert "rooms/ptl/A" in capsys.readouterr().out


def test_nothing_is_written_that_could_not_be_read(tmp_path: Path) -> None:
    for values in (np.array([[-1]]), np.array([[1.0]]), np.zeros((3, 1), dtype=int)):
        with pytest.raises(UserError, match="is not written"):
            write_arrays(tmp_path / "steps.h5", STEPS, {"rooms/ptl/A": values}, {"seeds": np.arange(1)})
    assert list(tmp_path.iterdir()) == []


def test_a_method_of_ones_own_may_have_parameters_and_values_of_its_own(tmp_path: Path) -> None:
    life = live("ptl")
    for record in life.records:
        record.q[:] = 7.0
    own = origin("ptl", 0)
    own |= {"method": "mine", "parameters": {**own["parameters"], "mine": {"depth": [1, 2], "decay": 0.5}}}
    write_learning(tmp_path / "mine.h5", life, ROOMS, own)
    with open_learning(tmp_path / "mine.h5") as file:
        assert file.parameters["mine"] == {"depth": [1, 2], "decay": 0.5}
    inspect.callback((tmp_path / "mine.h5",))
