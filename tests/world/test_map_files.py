"""Map files of this package and of other programs: what is read, what the reader chooses, and what it names."""

from __future__ import annotations

import re
import time
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from ptl.cli import commands
from ptl.config import MapOptions
from ptl.errors import UserError
from ptl.world.gridworld import MAX_CELLS, GridWorld
from ptl.world.map_files import generated_map, load_map, read_map
from ptl.world.mazes import FAMILIES

ROWS = ["@@@@@@@", "@.S.TG@", "@.WO..@", "@.....@", "@@@@@@@"]
WALKED = "#######\n#...#.#\n#.##..#\n#.....#\n#######\n"
HEADER = ["type octile", "height 5", "width 7", "map"]
PAIRS = ["0\tyard.map\t7\t5\t1\t1\t5\t3\t6", "0\tyard.map\t7\t5\t5\t1\t1\t3\t6", "1\tyard.map\t7\t5\t1\t1\t3\t3\t4"]


def written(folder: Path, name: str, content: str | bytes) -> Path:
    path = folder / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


def walls(world: GridWorld) -> str:
    return re.sub("[A-Z]", ".", world.text)


def refusal(path: Path, **options: object) -> str:
    with pytest.raises(UserError) as caught:
        load_map(path, **options)
    assert "\n" not in str(caught.value)
    return str(caught.value).removeprefix(f"{path}: ")


# -- this package's text


def test_a_byte_order_mark_and_windows_line_ends_are_no_part_of_a_map(tmp_path):
    plain = "#####\n#I.A#\n#####\n"
    path = written(tmp_path, "room.txt", b"\xef\xbb\xbf" + plain.replace("\n", "\r\n").encode())
    assert load_map(path).text == plain


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("####\n#I\tA#\n####\n", r"unknown letter '\t' (a tab) in row 2, column 3; use '#' for a wall"),
        ("####\n#IA# \n####\n", "unknown letter ' ' (a blank) in row 2, column 5"),
        ("####\n#IA#\n####\n\x1a", r"unknown letter '\x1a' (Ctrl-Z) in row 4, column 1"),
        ("####\n#I\u200bA#\n####\n", r"unknown letter '\u200b' (ZERO WIDTH SPACE) in row 2, column 3"),
        ("####\n#IA#\r####\n", r"unknown letter '\r' (a carriage return) in row 2, column 5"),
        ("####\n\n#IA#\n####\n", "row 2 is blank; remove the line"),
        ("####\n#IA#\n  \n####\n", "row 3 is blank; remove the line"),
        ("####\n#I.A#\n####\n", "row 2 has 5 cells but row 1 has 4; make all rows equally long"),
        ("####\r#IA#\r####\r", "its lines end in CR alone, as on old Macs"),
    ],
)
def test_what_cannot_be_seen_is_named(tmp_path, text, says):
    assert refusal(written(tmp_path, "room.txt", text)).startswith(says)


def test_start_and_goals_can_be_given_and_replace_those_of_the_text(tmp_path):
    path = written(tmp_path, "room.txt", "######\n#IA.B#\n######\n")
    assert load_map(path, start=[2, 4]).text == "######\n#.AIB#\n######\n"
    assert load_map(path, goals=[[2, 5], [2, 3]]).text == "######\n#IB.A#\n######\n"
    assert "row 2, column 3 is goal A" in refusal(path, start=[2, 3])
    assert "row 1, column 3 is a wall" in refusal(path, start=[1, 3])
    assert "row 2, column 9 is not on the map of 3 rows and 6 columns" in refusal(path, goals=[[2, 9]])
    assert "row 2, column 2 is given twice" in refusal(path, goals=[[2, 2]])


def test_a_text_without_letters_gets_them_only_if_a_seed_asks_for_it(tmp_path):
    path = written(tmp_path, "room.txt", "#####\n#...#\n#.#.#\n#####\n")
    assert refusal(path).startswith("no start; put the letter 'I' on a free cell")
    world, [note] = read_map(path, MapOptions(seed=3))
    assert set(world.goals) == set("ABCD") and "drawn with seed 3: --start " in note
    steps = world.distances_to(world.start)[list(world.goals.values())]
    assert (np.diff(steps) >= 0).all()
    assert read_map(path, MapOptions(seed=3)).world.text == world.text
    assert {read_map(path, MapOptions(seed=seed)).world.text for seed in range(5)} != {world.text}


# -- Moving AI


@pytest.mark.parametrize(
    "header",
    [
        HEADER,
        ["width 7", "height 5", "type tile", "map"],
        ["type\toctile", "height\t5 ", "width  7\t", "map  "],
        ["", "HEIGHT 5", "Width 7", "", "map"],
    ],
    ids=["plain", "width first", "tabs and blanks", "no type"],
)
@pytest.mark.parametrize("ends", [("\n", "\n"), ("\r\n", "\r\n"), ("\r\n", "\n"), ("\n", " \r\n")], ids=repr)
def test_moving_ai_maps_are_read(tmp_path, header, ends):
    text = "".join(line + ends[0] for line in header) + "".join(row + ends[1] for row in ROWS) + ends[1]
    world, [note] = read_map(written(tmp_path, "yard.map", text))
    assert walls(world) == WALKED and world.n_states == 12 and list(world.goals) == list("ABCDEF")
    assert "drawn with seed 0: --start " in note


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("height 5", "height 6", "height is 6 but there are 5 rows"),
        ("width 7", "width 8", "width is 8 but row 1 (line 5) has 7 cells"),
        ("@.....@", "@....@", "width is 7 but row 4 (line 8) has 6 cells"),
        ("@.....@\n", "\n", "width is 7 but row 4 (line 8) has 0 cells"),
        ("@.....@", "@..x..@", "unknown letter 'x' in row 4, column 4 of the rows (line 8)"),
        ("map\n", "", "line 4: '@@@@@@@' is not allowed there; a Moving AI map begins"),
        ("height 5\n", "", "height is missing"),
        ("height 5", "height five", "height 'five' is not allowed"),
        ("type octile", "# my yard\ntype octile", "line 1: '# my yard' is not allowed there"),
        ("height 5", "height 5\nheight 5", "line 3: 'height 5' is not allowed there"),
        ("height 5", f"height {MAX_CELLS}", f"the map has {7 * MAX_CELLS} cells, more than {MAX_CELLS}"),
        ("\n", "\r", "its lines end in CR alone"),
    ],
)
def test_moving_ai_maps_that_do_not_agree_with_themselves_are_refused(tmp_path, old, new, says):
    text = "\n".join([*HEADER, *ROWS]) + "\n"
    assert refusal(written(tmp_path, "yard.map", text.replace(old, new))).startswith(says)


def test_a_scenario_beside_a_map_gives_start_and_goals(tmp_path):
    path = written(tmp_path, "yard.map", "\n".join([*HEADER, *ROWS]) + "\n")
    scenario = written(tmp_path, "yard.map.scen", "\n".join(["version 1", *PAIRS]) + "\n")
    world, [note] = read_map(path)
    assert world.text == "#######\n#I..#.#\n#.##..#\n#B.C.A#\n#######\n"
    assert "yard.map.scen: start of the first of 3 pairs, goals of pairs 1, 2, 3" in note
    assert load_map(path, goals=[[2, 6]]).text.count("A") == 1 and load_map(path, goals=[[2, 6]]).text[9] == "I"
    assert read_map(path, MapOptions(start=[2, 2], goals=[[2, 3]])).notes == ()
    scenario.write_text("version 1\n0\tyard.map\t9\t5\t1\t1\t5\t3\t6\n")
    assert "line 2: width 9 and height 5 are not those of the map, 7 and 5" in refusal(path)
    scenario.write_text("version 1\n0\tyard.map\t7\t5\t0\t1\t5\t3\t6\n")
    assert "line 2: the start x 0, y 1 is not a free cell" in refusal(path)
    scenario.write_text("version 1\nno pair\n")
    assert "line 2: is no pair of a Moving AI scenario" in refusal(path)


def test_cells_that_the_start_does_not_reach_are_walls_and_counted(tmp_path):
    path = written(tmp_path, "two.map", "type octile\nheight 1\nwidth 7\nmap\n..@....\n")
    world, notes = read_map(path)
    assert walls(world) == "###....\n" and notes[-1].endswith(
        "2 free cells that the start does not reach are walls here"
    )
    assert walls(load_map(path, start=[1, 1])) == "..#####\n"
    assert "goal 'A' in row 1, column 7 cannot be reached" in refusal(path, start=[1, 1], goals=[[1, 7]])


# -- ROS map_server

YAML = "image: office.pgm\nresolution: 0.05\norigin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.25\n"
PIXELS = [[0, 0, 0, 0, 0, 0], [0, 254, 254, 254, 205, 0], [0, 254, 254, 254, 254, 0], [0, 0, 0, 0, 100, 0]]
ROOM = "######\n#...##\n#....#\n######\n"


def office(folder: Path, pixels: list[list[int]], *, maximum: int = 255, settings: str | None = YAML) -> Path:
    rows, columns = len(pixels), len(pixels[0])
    kind = np.uint8 if maximum < 256 else ">u2"
    head = f"P5\n# CREATOR: map_saver 0.050 m/pix\n{columns} {rows}\n{maximum}\n".encode()
    written(folder, "office.pgm", head + np.array(pixels, dtype=kind).tobytes())
    return folder / "office.pgm" if settings is None else written(folder, "office.yaml", settings)


def test_unknown_pixels_are_not_free_whatever_the_threshold(tmp_path):
    path = office(tmp_path, PIXELS)
    for name in ("office.yaml", "office.pgm"):
        world, notes = read_map(path.with_name(name))
        assert walls(world) == ROOM
        assert "4 x 6 pixels: 7 free, 15 occupied, 2 unknown" in notes[0]


@pytest.mark.parametrize("maximum", [100, 65535])
def test_images_of_other_depths_are_read(tmp_path, maximum):
    pixels = [[round(value * maximum / 255) for value in row] for row in PIXELS]
    assert walls(load_map(office(tmp_path, pixels, maximum=maximum))) == ROOM


def test_plain_images_with_comments_are_read(tmp_path):
    office(tmp_path, PIXELS)
    rows = "# first\n".join(" ".join(map(str, row)) + "\n" for row in PIXELS)
    written(tmp_path, "office.pgm", f"P2 # plain\n6 # columns\n4\n255\n{rows}")
    assert walls(load_map(tmp_path / "office.yaml")) == ROOM


def test_an_image_with_the_line_ends_of_windows_in_its_header_is_read(tmp_path):
    path = office(tmp_path, PIXELS)
    content = (tmp_path / "office.pgm").read_bytes()
    written(tmp_path, "office.pgm", content.replace(b"\n", b"\r\n"))
    assert walls(load_map(path)) == ROOM


def test_negated_images_and_other_thresholds(tmp_path):
    negated = [[255 - value for value in row] for row in PIXELS]
    path = office(tmp_path, negated, settings=YAML.replace("negate: 0", "negate: 1"))
    assert walls(load_map(path)) == "######\n#....#\n#....#\n######\n"  # 50 of 255 is below 0.25, and no 205
    narrow = YAML.replace("negate: 0", "negate: true").replace("free_thresh: 0.25", "free_thresh: 5e-2")
    assert walls(load_map(office(tmp_path, negated, settings=narrow))) == ROOM


def test_pixels_are_merged_to_cells_that_are_free_if_all_are(tmp_path):
    pixels = np.full((5, 8), 254)
    pixels[0, 0], pixels[3, 7] = 0, 205
    path = office(tmp_path, pixels.tolist())
    assert walls(load_map(path, cell=0.1)) == "#...\n...#\n####\n"  # the last row is half outside of the image
    assert "--cell 0.12 is no multiple of the resolution 0.05; give 0.1 or 0.15" in refusal(path, cell=0.12)
    text = written(tmp_path, "room.txt", "####\n#IA#\n####\n")
    assert "the map is not an image of ROS map_server" in refusal(text, cell=0.1)


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("image: office.pgm\n", "image: lost.pgm\n", "cannot be read (no such file)"),
        ("image: office.pgm\n", "image: office.yaml\n", "is no PGM image"),
        ("image: office.pgm\n", "image: 7\n", "does not name its image"),
        ("negate: 0", "negate: 2", "negate 2 is not allowed; give 0 or 1"),
        ("free_thresh: 0.25", "free_thresh: 25", "free_thresh 25 is not allowed; give a number from 0 to 1"),
        ("free_thresh: 0.25", "free_thresh: 0.7", "free_thresh 0.7 exceeds occupied_thresh 0.65"),
        ("negate: 0", "negate: 0\nmode: raw", "mode 'raw' is not read"),
        ("negate: 0", "negate: [", "is not YAML"),
        ("free_thresh: 0.25", "free_thresh:", "free_thresh without a value is not allowed; give a number"),
    ],
)
def test_settings_of_an_image_that_make_no_map_are_refused(tmp_path, old, new, says):
    assert says in refusal(office(tmp_path, PIXELS, settings=YAML.replace(old, new)))


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (b"P5\n2 2\n255\n\0\0\0", "width 2 and height 2 make 4 pixels, but there are 3"),
        (b"P2\n2 2\n255\n0 0 0", "width 2 and height 2 make 4 pixels, but there are 3"),
        (b"P2\n2 2\n255\n0 0 0 0 0", "make 4 pixels, but there are 5"),
        (b"P2\n2 2\n255\n0 0 x 0", "something else than numbers among its pixels"),
        (b"P5\n2 2\n9\n\0\0\x0a\0", "pixel 10 is not from 0 to the image's maximum 9"),
        (b"P2\n2 2\n9\n0 -1 0 0", "pixel -1 is not from 0 to the image's maximum 9"),
        (b"P5\n2 x\n255\n", "has no height where the header"),
        (b"P5\n2 2\n70000\n", "maximum 70000 is not allowed"),
        (b"P5\n99999 99999\n255\n", "has 99999 x 99999 pixels, more than"),
    ],
)
def test_damaged_images_are_refused(tmp_path, content, says):
    assert says in refusal(written(tmp_path, "office.pgm", content))


def test_the_largest_images_and_maps_are_read_quickly(tmp_path):
    rows = np.full((2048, 2048), 254, dtype=np.uint8)
    path = office(tmp_path, [[0]])
    written(tmp_path, "office.pgm", b"P5\n2048 2048\n255\n" + rows.tobytes())
    assert "the map has 4194304 cells, more than 1048576; merge pixels with --cell METRES, say 0.1" in refusal(path)
    started = time.process_time()
    assert load_map(path, cell=0.1).n_states == 2**20
    assert time.process_time() - started < 20


# -- mazes of other environments


@pytest.mark.parametrize(
    ("text", "letters"),
    [
        ("*****\n*P G*\n* *F*\n*G  *\n*****\n", "#####\n#I.A#\n#.#.#\n#B..#\n#####\n"),
        ("SFFF\nFHFH\nFFFH\nHFFG\n", "I...\n.#.#\n...#\n#..A\n"),
        ("11111\n1r0g1\n1c001\n11111\n", "#####\n#I.A#\n#B..#\n#####\n"),
        ("1 1 1\n1 R 0\n1 G 1\n", "###\n#I.\n#A#\n"),
        ("[[1, 1, 1],\n [1, R, 0],\n [1, 'g', 1]]\n", "###\n#I.\n#A#\n"),
        ('["SFF", "FHF",\n "FFG"]\n', "I..\n.#.\n..A\n"),
    ],
    ids=["labmaze", "FrozenLake", "PointMaze", "PointMaze with blanks", "PointMaze as a list", "FrozenLake as a list"],
)
def test_mazes_of_other_environments_are_read(tmp_path, text, letters):
    world, notes = read_map(written(tmp_path, "maze.txt", text))
    assert world.text == letters and any("read as" in note for note in notes)


def test_mazes_without_a_start_get_one(tmp_path):
    world, notes = read_map(written(tmp_path, "maze.txt", "#####\\#OOG#\\#####"))
    assert walls(world) == "#####\n#...#\n#####\n" and world.goals == {"A": 2} and "--start 2," in notes[-1]
    world, notes = read_map(written(tmp_path, "maze.txt", "1,1,1,1\n1,0,0,1\n1,1,1,1\n"))
    assert walls(world) == "####\n#..#\n####\n" and "--goal 2," in notes[-1]


def test_a_text_that_can_be_two_formats_is_refused_with_the_choice(tmp_path):
    path = written(tmp_path, "maze.txt", "###\n#O#\n#G#\n###\n")
    assert "can be read as text or as maze2d; say which: --format text or --format maze2d" in refusal(path)
    assert load_map(path, format="maze2d").n_states == 2
    assert "no start" in refusal(path, format="text")


def test_of_many_starts_the_first_counts_and_is_named(tmp_path):
    world, notes = read_map(written(tmp_path, "maze.txt", "*****\n*PGP*\n*****\n"))
    assert world.text == "#####\n#IA.#\n#####\n" and "the start is the first of 2, in row 2, column 2" in notes[1]


# -- other formats


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (b"\x89PNG\r\n\x1a\n", "is a PNG image; save it as PGM"),
        (b"\xff\xd8\xff\xe0", "is a JPEG image"),
        (b"P6\n1 1\n255\nabc", "is a PPM image"),
        (b'{"width": 3, "layers": []}', "is JSON; maps are"),
        (b"[1, 0]", "is JSON"),
        (b'<?xml version="1.0"?>\n<!-- a -->\n<map version="1.10">\n</map>', "is a TMX map (Tiled)"),
        (b"<sdf version='1.7'></sdf>", "is XML with the root sdf"),
        (b"version 1\n0\ta.map\t1\t1\t0\t0\t0\t0\t0\n", "is a Moving AI scenario"),
        (b"..@\n.T.\n", "is a Moving AI map without its header"),
        ("####\n#IA#\n####\n".encode("utf-16"), "is UTF-16 text; save it as UTF-8"),
        (b"PK\3\4aaaa", "is a ZIP archive"),
        (b"import numpy\n", "is a program"),
    ],
)
def test_other_formats_are_named(tmp_path, content, says):
    assert refusal(written(tmp_path, "something.txt", content)).startswith(says)
    assert refusal(written(tmp_path, "plan.yaml", b"floor: 1\n")).startswith("is YAML without the key 'image'")


# -- commands


def called(*arguments: object) -> str:
    done = CliRunner().invoke(commands, list(map(str, arguments)))
    assert done.exception is None, done.exception
    return done.output


def test_commands_take_start_and_goals_and_say_what_was_drawn(tmp_path):
    path = written(tmp_path, "yard.map", "\n".join([*HEADER, *ROWS]) + "\n")
    shown = called("show-map", path, "--start", "2,2", "--goal", "4,6", "--goal", "2,6")
    assert "start I  at row 2, column 2" in shown and "goal  A  at row 4, column 6, 6 steps" in shown
    drawn = called("show-map", path, "--map-seed", 4)
    places = re.search("drawn with seed 4: (.*) \\(", drawn)[1].split()
    assert called("show-map", path, *places).split("counted from 1:")[1] == drawn.split("counted from 1:")[1]
    for wrong in ("2", "a,b", "2,2,2", "-1,2"):
        refused = CliRunner().invoke(commands, ["show-map", str(path), "--start", wrong]).exception
        assert "give ROW,COLUMN, counted from 1" in str(refused)


@pytest.mark.parametrize("family", FAMILIES)
def test_generated_maps_have_about_the_size_asked_for_and_follow_from_the_seed(tmp_path, family):
    world = generated_map(family, 300, 7)
    assert 150 < world.n_states < 600 and list(world.goals) == list("ABCDEF")
    assert generated_map(family, 300, 7).text == world.text != generated_map(family, 300, 8).text
    for states in (30, 5000, 20000):
        assert 0.4 < generated_map(family, states, 7).n_states / states < 1.6
    path = tmp_path / "own.txt"
    called("make-map", family, "--size", 300, "--seed", 7, "--output", path)
    assert load_map(path).text == world.text
