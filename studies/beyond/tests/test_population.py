"""The population of maps: families, sizes, bands, sequences and the tracked table."""

from __future__ import annotations

import hashlib
import re
from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner

from ptl.errors import UserError
from ptl.world.gridworld import GridWorld
from ptl.world.mazes import FAMILIES, FREE, largest_part
from studies.beyond.maps import SEQUENCES, checked_map, make_map, place_tasks, winding
from studies.beyond.population import BANDS, MAPS, command, describe, read_population, to_csv
from studies.beyond.population import TABLE as PATH

TABLE = read_population()
SMALL = [entry for entry in TABLE if entry.size == 300]


def paths_of(world: GridWorld) -> list[int]:
    return world.distances_to(world.start)[list(world.goals.values())].tolist()


def test_the_table_is_complete_and_its_bands_are_disjoint():
    for (band, size), number in MAPS.items():
        for family in FAMILIES:
            seeds = [e.seed for e in TABLE if (e.band, e.size, e.family) == (band, size, family)]
            assert seeds == list(range(BANDS[band], BANDS[band] + number))
    assert len(TABLE) == 6 * sum(MAPS.values())
    by_band = [{entry.hash for entry in TABLE if entry.band == band} for band in BANDS]
    assert not by_band[0] & by_band[1]
    assert len({entry.hash for entry in TABLE}) == len(TABLE)


@pytest.mark.parametrize("entry", [SMALL[i] for i in range(0, len(SMALL), 41)], ids=str)
def test_a_row_follows_from_its_seed_and_says_the_truth(entry):
    assert describe(entry.band, entry.family, entry.size, entry.seed) == entry
    world = entry.world()
    assert hashlib.sha256(world.text.encode()).hexdigest().startswith(entry.hash)
    assert (world.n_states, paths_of(world)) == (entry.states, list(entry.shortest_paths))
    rows, columns = np.array([world.cells[goal] - world.cells[world.start] for goal in world.goals.values()]).T
    assert winding(world) == pytest.approx(np.mean(paths_of(world) / np.hypot(rows, columns)))
    with pytest.raises(UserError, match=rf"map {entry.name}: has the digest {entry.hash}, not 0+ as planned; .*numpy"):
        replace(entry, hash="0" * 16).world()
    other = checked_map(entry.family, entry.size, entry.seed, entry.hash, "random")
    assert set(other.goals.values()) == set(world.goals.values())


def test_the_table_is_read_back(tmp_path):
    path = tmp_path / "maps.csv"
    path.write_text(to_csv(iter(TABLE[:3])))
    assert read_population(path) == TABLE[:3]
    path.write_text("band,family\n1,2\n")
    with pytest.raises(UserError, match=r"python -m studies\.beyond\.population"):
        read_population(path)


@pytest.mark.parametrize(
    ("column", "text"),
    [
        ("band", "own"), ("family", "castle"), ("size", "301"), ("size", "0"), ("seed", "-1"), ("seed", "1000"),
        ("seed", "9" * 5000), ("size", "9" * 400), ("states", "0"), ("states", "5000"), ("shortest_paths", "1 2 3"),
        ("shortest_paths", "1 2 7 9 13 0"), ("shortest_paths", "1 2 7 9 13 999"), ("winding", "nan"),
        ("winding", "0.5"), ("hash", "x"),
    ],
)  # fmt: skip
def test_rows_of_no_map_of_the_population_are_refused(column, text, tmp_path):
    path = tmp_path / "maps.csv"
    header, *rows = to_csv(entry for entry in TABLE if entry.seed in (4000, 4001)).splitlines()
    cells = dict(zip(header.split(","), rows[1].split(","), strict=True))
    path.write_text("\n".join([header, rows[0], ",".join({**cells, column: text}.values()), *rows[2:]]))
    with pytest.raises(UserError, match=r"maps\.csv: line 3: is no row of a table of maps"):
        read_population(path)


def test_maps_are_not_written_to_a_file(tmp_path):
    (tmp_path / "maps").touch()
    arguments = [str(PATH), "--maps", str(tmp_path / "maps")]
    assert "is a file" in CliRunner().invoke(command, arguments).output


def test_the_maps_of_a_band_are_written_as_text(tmp_path):
    path = tmp_path / "maps.csv"
    path.write_text(to_csv(entry for entry in TABLE if entry.seed in (1000, 4000) and entry.size == 300))
    assert CliRunner().invoke(command, [str(path), "--maps", str(tmp_path / "maps"), "--band", "tuning"]).exit_code == 0
    written = {file.stem: file.read_text() for file in (tmp_path / "maps").iterdir()}
    assert written == {f"{family}_300_1000": make_map(family, 300, 1000).text for family in FAMILIES}


def test_sizes_are_about_what_was_wanted():
    for entry in TABLE:
        assert 0.7 < entry.states / entry.size < 1.35, entry
        assert min(entry.shortest_paths) >= 1 and list(entry.shortest_paths) == sorted(entry.shortest_paths)


@pytest.mark.parametrize("family", FAMILIES)
def test_all_free_cells_are_joined(family):
    world = make_map(family, 300, 1003)
    assert (world.distances_to(world.start) >= 0).all()
    assert make_map(family, 300, 1003).text == world.text != make_map(family, 300, 1002).text


def dead_ends(world: GridWorld) -> int:
    walls = (world.successors == np.arange(world.n_states)[:, None]).sum(axis=1)
    return int((walls == 3).sum())


def test_a_perfect_maze_is_a_tree_and_a_braided_one_has_no_dead_ends():
    perfect, braided = make_map("maze", 300, 1001), make_map("braided", 300, 1001)
    edges = (perfect.successors != np.arange(perfect.n_states)[:, None]).sum() // 2
    assert edges == perfect.n_states - 1
    assert dead_ends(perfect) > 20 and dead_ends(braided) == 0


def test_a_chain_is_passed_door_by_door():
    grid = FAMILIES["chain"](np.random.default_rng(4), 300)
    doors = [column for column in range(1, grid.shape[1] - 1) if (grid[1:-1, column] == FREE).sum() == 1]
    assert 5 <= len(doors) <= 8
    grid[:, doors[2]] = "#"
    assert len(largest_part(grid)) < (grid == FREE).sum()


def test_sequences_of_tasks():
    worlds = {name: make_map("rooms", 300, 1005, name) for name in SEQUENCES}
    assert len({re.sub("[A-F]", ".", world.text) for world in worlds.values()}) == 1
    goals = {name: list(world.goals.values()) for name, world in worlds.items()}
    paths = {name: paths_of(world) for name, world in worlds.items()}
    assert paths["increasing"] == sorted(paths["random"])
    assert paths["reversed"] == paths["increasing"][::-1]
    assert set(goals["increasing"]) == set(goals["random"]) and goals["random"] != goals["increasing"]
    spread = {
        name: np.mean([worlds[name].distances_to(first)[list(places)].mean() for first in places])
        for name, places in goals.items()
    }
    assert spread["clustered"] < 0.5 * spread["random"]
    detour = {name: _least_detours(worlds[name]) for name in SEQUENCES}
    assert detour["adversarial"] > max(value for name, value in detour.items() if name != "adversarial")


def _least_detours(world: GridWorld) -> float:
    """Mean over the goals after the first of the least path / straight line from start and earlier goals."""
    places = [world.start, *world.goals.values()]
    values = []
    for index, goal in enumerate(places[2:], start=2):
        paths = world.distances_to(goal)
        values.append(min(paths[p] / np.hypot(*(world.cells[p] - world.cells[goal])) for p in places[:index]))
    return float(np.mean(values))


def test_a_grid_without_room_for_six_tasks_is_refused():
    with pytest.raises(UserError, match="with six tasks"):
        place_tasks(np.full((3, 3), FREE), "tiny", 1)
