"""Reading maps: states, transitions, distances, and messages for maps that are wrong."""

from __future__ import annotations

import time

import mazes
import numpy as np
import oracles
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from projects import MAPS

from ptl.errors import UserError
from ptl.world.gridworld import GridWorld
from ptl.world.map_files import load_map

SMALL = "#####\n#I.A#\n#.#.#\n#####\n"  # states 0 1 2 over 3 4

FIGURES_5_TO_7 = {  # states, and the shortest paths from I to A..F
    "env1": (706, [25, 36, 47, 58, 69, 80]),
    "env2": (243, [5, 9, 15, 19, 31, 30]),
    "fitted/env1": (1014, [27, 40, 53, 66, 79, 92]),
    "fitted/env2": (265, [7, 11, 17, 21, 30, 30]),
    "env3": (301, [16, 18, 28, 33, 21, 20]),
}


def test_states_and_transitions_of_a_map_worked_out_by_hand():
    world = GridWorld.from_text(SMALL, name="small")
    assert (world.name, world.text, world.shape, world.n_states) == ("small", SMALL, (4, 5), 5)
    assert world.cells.tolist() == [[1, 1], [1, 2], [1, 3], [2, 1], [2, 3]]
    assert (~world.walls).astype(int).tolist() == [[0] * 5, [0, 1, 1, 1, 0], [0, 1, 0, 1, 0], [0] * 5]
    assert world.successors.tolist() == [[0, 3, 0, 1], [1, 1, 0, 2], [2, 4, 1, 2], [0, 3, 3, 3], [2, 4, 4, 4]]
    assert (world.start, world.goals) == (0, {"A": 2})
    assert (world.cells.dtype, world.successors.dtype, world.walls.dtype) == (np.int32, np.int32, bool)


def test_distances_worked_out_by_hand():
    world = GridWorld.from_text(SMALL)
    assert world.distances_to(3).tolist() == [1, 2, 3, 0, 4]
    assert world.distances_to(3).dtype == np.int32
    assert world.shortest_path_length(3, 4) == world.shortest_path_length(4, 3) == 4
    assert world.shortest_path_length(2, 2) == 0


def test_cells_behind_walls_are_states_without_a_path():
    world = GridWorld.from_text("IA#..\n")
    assert world.n_states == 4
    assert world.distances_to(world.start).tolist() == [0, 1, -1, -1]
    assert world.shortest_path_length(0, 3) == -1


def test_the_border_of_the_text_acts_as_a_wall():
    world = GridWorld.from_text("I.\n.A\n")
    assert world.successors.tolist() == [[0, 2, 0, 1], [1, 3, 0, 1], [0, 2, 2, 3], [1, 3, 2, 3]]


def test_a_map_of_one_row():
    world = GridWorld.from_text("I..A")
    assert world.successors.tolist() == [[0, 0, 0, 1], [1, 1, 0, 2], [2, 2, 1, 3], [3, 3, 2, 3]]


def test_state_at_is_the_inverse_of_cells():
    world = GridWorld.from_text(SMALL)
    numbers = [world.state_at(row, column) for row, column in world.cells.tolist()]
    assert numbers == list(range(world.n_states))
    for row, column in [(0, 0), (2, 2), (-1, 1), (1, -4), (1, 5), (4, 1)]:
        with pytest.raises(ValueError, match=f"row {row}, column {column}"):
            world.state_at(row, column)


def test_to_grid_lays_values_out_as_the_map():
    world = GridWorld.from_text(SMALL)
    grid = world.to_grid(np.arange(5), fill=-1)
    assert grid.tolist() == [[-1] * 5, [-1, 0, 1, 2, -1], [-1, 3, -1, 4, -1], [-1] * 5]
    assert np.array_equal(np.isnan(world.to_grid(np.arange(5))), world.walls)


def test_diagonal_is_that_of_the_free_cells_not_of_the_text():
    inner = GridWorld.from_text("I..\n..A\n")
    framed = GridWorld.from_text("#######\n#######\n##I..##\n##..A##\n#######\n#######\n#######\n")
    assert framed.diagonal == inner.diagonal == pytest.approx(np.hypot(2, 3))


@pytest.mark.parametrize("name", FIGURES_5_TO_7)
def test_sizes_and_shortest_paths_of_the_maps(name):
    world = load_map(MAPS / f"{name}.txt")
    n_states, lengths = FIGURES_5_TO_7[name]
    assert world.n_states == n_states
    assert list(world.goals) == list("ABCDEF")
    assert [world.shortest_path_length(world.start, goal) for goal in world.goals.values()] == lengths
    from_start = oracles.distances(world.successors)[world.start]
    assert [int(from_start[goal]) for goal in world.goals.values()] == lengths


def test_environment_1_is_a_chain_of_equal_rooms():
    assert mazes.chain_of_rooms(7, 10) == load_map(MAPS / "env1.txt").text


@settings(max_examples=40, deadline=None, derandomize=True)
@given(text=mazes.maps(), data=st.data())
def test_any_map_agrees_with_its_text_and_with_scipy(text, data):
    world = GridWorld.from_text(text)
    rows = text.splitlines()
    assert world.text == text
    assert world.n_states == sum(len(row) - row.count("#") for row in rows)
    for letter, state in {"I": world.start, **world.goals}.items():
        row, column = world.cells[state]
        assert rows[row][column] == letter
    states = np.arange(world.n_states)
    north, south, west, east = world.successors.T
    for there, back in ((north, south), (south, north), (west, east), (east, west)):
        moved = there != states
        assert np.array_equal(back[there[moved]], states[moved])
    target = data.draw(st.integers(0, world.n_states - 1))
    expected = oracles.distances(world.successors)[:, target]
    assert np.array_equal(world.distances_to(target), np.where(np.isinf(expected), -1, expected))


@pytest.mark.parametrize("ending", ["\n", "\n\n", "", "\r\n", "\r\n\r\n"])
def test_line_ends_do_not_matter(tmp_path, ending):
    text = SMALL.strip().replace("\n", "\r\n" if "\r" in ending else "\n") + ending
    file = tmp_path / "map.txt"
    file.write_bytes(text.encode())
    for world in (GridWorld.from_text(text), load_map(file), load_map(str(file))):
        assert world.text == SMALL
        assert world.cells.tolist() == [[1, 1], [1, 2], [1, 3], [2, 1], [2, 3]]


WRONG_MAPS = {
    "empty": ("", ["empty"]),
    "only line ends": ("\n\n\n", ["empty"]),
    "only blanks": ("   \n   \n", ["empty"]),
    "no start": ("..A\n", ["no start", "'I'"]),
    "only walls": ("###\n###\n", ["no start", "'I'"]),
    "two starts": ("I.A\n..I\n", ["'I'", "row 1, column 1", "row 2, column 3"]),
    "one goal twice": ("I.A\n.A.\n", ["'A'", "row 1, column 3", "row 2, column 2"]),
    "no goal": ("I..\n...\n", ["no goal"]),
    "goal behind walls": ("I.#.\n..#B\n", ["'B'", "row 2, column 4", "reach"]),
    "a goal among others behind walls": ("IA#.\n..#B\n", ["'B'", "row 2, column 4", "reach"]),
    "short row": ("####\n#IA\n####\n", ["row 2", "3", "4"]),
    "long row": ("####\n#IA#\n#####\n", ["row 3", "5", "4"]),
    "blank line inside": ("####\n\n#IA#\n####\n", ["row 2"]),
    "tab": ("####\n#I\tA\n####\n", ["\\t", "row 2, column 3"]),
    "blank": ("####\n#I A\n####\n", ["' '", "row 2, column 3"]),
    "small letter": ("####\n#IAb\n####\n", ["'b'", "row 2, column 4"]),
    "digit": ("#1##\n#IA#\n####\n", ["'1'", "row 1, column 2"]),
    "letter of another alphabet": ("####\n#IA#\n##\u00c4#\n", ["'\u00c4'", "row 3, column 3"]),
    "another line separator": ("#IA\u2028###\n", ["\\u2028", "row 1, column 4"]),
    "old line end inside": ("#IA\r###\n", ["\\r", "row 1, column 4"]),
}


@pytest.mark.parametrize("case", WRONG_MAPS)
def test_a_wrong_map_is_refused_in_one_line_with_cell_and_remedy(case):
    text, parts = WRONG_MAPS[case]
    with pytest.raises(UserError) as caught:
        GridWorld.from_text(text, name="maps/mine.txt")
    message = str(caught.value)
    assert "\n" not in message
    assert message.startswith("maps/mine.txt: ")
    assert ";" in message, "the remedy follows a semicolon"
    for part in parts:
        assert part in message


def test_a_task_without_its_letter_is_refused():
    world = GridWorld.from_text("IA.D\n", name="maps/mine.txt")
    assert world.goal("D") == 3
    for letter in ("B", "I", "AD"):
        with pytest.raises(UserError, match=f"maps/mine.txt: no goal '{letter}'.*; .*AD"):
            world.goal(letter)


def test_a_map_file_that_cannot_be_read_is_refused(tmp_path):
    with pytest.raises(UserError, match=r"absent\.txt: cannot be read.*; "):
        load_map(tmp_path / "absent.txt")
    with pytest.raises(UserError, match=r"cannot be read.*; "):
        load_map(tmp_path)
    picture = tmp_path / "picture.txt"
    picture.write_bytes(b"\x89ABC\xff\xfe")
    with pytest.raises(UserError, match=r"picture\.txt: byte 1 is not UTF-8 text; "):
        load_map(picture)
    faulty = tmp_path / "faulty.txt"
    faulty.write_text("I..\n")
    with pytest.raises(UserError, match=r"faulty\.txt: no goal"):
        load_map(faulty)


def test_a_huge_winding_corridor_is_read_in_time():
    grid = mazes.framed(999, 1000)
    grid[2:-1:2, 1:-1] = "#"
    grid[2:-1:4, -2] = grid[4:-1:4, 1] = "."
    grid[1, 1], grid[997, 998] = "I", "A"
    text = mazes.to_text(grid)
    began = time.process_time()
    world = GridWorld.from_text(text)
    assert world.shortest_path_length(world.start, world.goals["A"]) == 499 * 997 + 2 * 498
    assert time.process_time() - began < 2
