"""The reader of map files: texts of this package, and maps that other programs write.

The format follows from the content: this package's text (`ptl.world.gridworld`), Moving AI with its scenario, images
of ROS map_server, and texts of labmaze, FrozenLake, PointMaze and maze2d (`ptl.world.formats`). A map without a start
or goals gets them as asked for, or drawn; every choice that the file does not make is a note of the reader.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ptl.config import MapOptions
from ptl.errors import UserError
from ptl.world.formats import GOALS, Cell, Drawing, mazes, moving_ai, ros, shown
from ptl.world.gridworld import FREE, MAX_CELLS, START, WALL, GridWorld
from ptl.world.mazes import draw

MAX_BYTES = 4 * MAX_CELLS
"""Maximum size of a text in bytes; of a larger one nothing is read."""

MAX_IMAGE_BYTES = 8 * ros.MAX_PIXELS
"""Maximum size of an image in bytes."""

DRAWN_GOALS = 6
"""Number of goals that are drawn for a map without goals, as many as the article's tasks."""

MAGIC = {
    rb"\x89PNG": "a PNG image", rb"\xff\xd8\xff": "a JPEG image", rb"GIF8": "a GIF image", rb"II\*\x00": "a TIFF image",
    rb"MM\x00\*": "a TIFF image", rb"BM.{4}\x00{4}": "a BMP image", rb"RIFF.{4}WEBP": "a WebP image",
    rb"P[14]\s": "a PBM image", rb"P[36]\s": "a PPM image", rb"P7\s": "a PAM image", rb"%PDF": "a PDF document",
    rb"PK\x03\x04": "a ZIP archive", rb"\x1f\x8b": "a gzip archive", rb"\x89HDF": "an HDF5 file",
    rb"\x93NUMPY": "a numpy file", rb"\xff\xfe|\xfe\xff": "UTF-16 text", rb"SQLite format 3": "an SQLite file",
}  # fmt: skip
"""Patterns of the first bytes of files that are named but not read."""

REMEDIES = {
    " image": "save it as PGM", "UTF-16": "save it as UTF-8", "archive": "unpack it", "scenario": "name its map",
    "header": "put the lines 'type octile', 'height ROWS', 'width COLUMNS' and 'map' above them",
}  # fmt: skip
"""What to do with a kind of file that is named, by a word in its name."""

READ = "this package's text, Moving AI .map, ROS map_server (PGM with YAML), labmaze, FrozenLake, PointMaze or maze2d"


class MapRead(NamedTuple):
    """A map, and what the reader chose that the file leaves open (a sentence each)."""

    world: GridWorld
    notes: tuple[str, ...]


def load_map(path: str | Path, **options: Any) -> GridWorld:
    """Read a map file; ``options`` are the keys of `ptl.config.MapOptions`, see `read_map`."""
    return read_map(path, MapOptions(**options)).world


def read_map(path: str | Path, options: MapOptions | None = None) -> MapRead:
    """Read a map file.

    Parameters
    ----------
    options : MapOptions, optional
        Start, goals and whatever else the file leaves open, the slip of the world too.

    Raises
    ------
    UserError
        When the file cannot be read, is of another format, which is named, or is no map with such a start and goals.
    """
    options = options or MapOptions()
    world, notes = _read(Path(path), options)
    return MapRead(world.with_slip(options.slip), notes)


def _read(path: Path, options: MapOptions) -> MapRead:
    content = _content(path)
    if content[:2] in (b"P2", b"P5") and content[2:3].isspace():
        image, settings = path, next(filter(Path.is_file, map(path.with_suffix, (".yaml", ".yml"))), None)
        return _placed(_ros(image, content, settings, options), options, path)
    text = mazes.unlisted(_text(content, path))
    kind = options.format or _format_of(text, path)
    if kind != "ros" and options.cell:
        raise UserError(f"{path}: metres of a cell (--cell) are given, but the map is not an image of ROS map_server")
    if kind == "text":
        return _own(text, options, path)
    if kind == "ros":
        image = path.parent / str(_settings(path).get("image", ""))
        return _placed(_ros(image, _content(image), path, options), options, path)
    if kind == "moving_ai":
        return _placed(_moving_ai(text, options, path), options, path)
    return _placed(mazes.read(text, kind, str(path), MAX_CELLS), options, path)


def generated_map(family: str, states: int, seed: int) -> GridWorld:
    """Return a map of a family of `ptl.world.mazes` with a start and six goals; equal arguments give equal maps."""
    free = draw(family, states, seed) != WALL
    return _placed(Drawing(free), MapOptions(seed=seed), Path(f"{family}_{states}_{seed}")).world


def read_text(path: str | Path) -> str:
    """Return the UTF-8 text of a file with a map or a table of maps; pipes, devices and what is huge are refused.

    Line ends are LF, and a byte order mark is left out.

    Raises
    ------
    UserError
    """
    return _text(_content(Path(path)), Path(path))


# -- content ------------------------------------------------------------------------------------------------------


def _content(path: Path) -> bytes:
    try:
        if not path.is_file():
            raise UserError(f"{path}: cannot be read (no such file); check the path of the map")
        with path.open("rb") as file:
            first = file.read(64)
            limit = MAX_IMAGE_BYTES if first[:2] in (b"P2", b"P5") else MAX_BYTES
            content = first + file.read(limit + 1 - len(first))
    except (OSError, ValueError) as error:  # ValueError: a null byte in the path
        reason = getattr(error, "strerror", None) or error
        raise UserError(f"{path}: cannot be read ({reason}); check the path of the map") from error
    for magic, kind in MAGIC.items():
        if re.match(magic, content, re.DOTALL):
            raise UserError(f"{path}: is {kind}; {_remedy(kind)}")
    if len(content) > limit:
        raise UserError(f"{path}: is larger than a map of {MAX_CELLS} cells can be; use a smaller one")
    return content


def _text(content: bytes, path: Path) -> str:
    try:
        text = content.decode("utf-8-sig").replace("\r\n", "\n")
    except UnicodeDecodeError as error:
        raise UserError(f"{path}: byte {error.start + 1} is not UTF-8 text; save the map as plain text") from error
    if "\r" in text and "\n" not in text:
        raise UserError(f"{path}: its lines end in CR alone, as on old Macs; save it with LF or CR LF")
    return text


def _format_of(text: str, path: Path) -> str:
    """Return the format of a text; one that is not read is named."""
    if moving_ai.HEADER.search(text[:1000]):
        return "moving_ai"
    if re.search(r"^image[ \t]*:", text, re.MULTILINE):
        return "ros"
    if kind := _named(text, path):
        raise UserError(f"{path}: is {kind}; {_remedy(kind)}")
    kinds = mazes.candidates(text)
    if len(kinds) > 1:
        raise UserError(
            f"{path}: can be read as {' or as '.join(kinds)}; say which: --format {' or --format '.join(kinds)}"
            " (map_options: {format: ...} in a configuration)"
        )
    return kinds[0] if kinds else "text"  # whose reader names what is wrong


def _named(text: str, path: Path) -> str:
    """Return what a text is that is no map, empty if it can be one."""
    start = text.lstrip()
    if start[:1] in ("{", "["):
        try:
            json.loads(text)
        except (ValueError, RecursionError):
            return "" if start[0] == "[" else "a text that begins like JSON"
        return "JSON"
    if start[:1] == "<":
        root = re.search(r"<([A-Za-z][\w:.-]*)", re.sub(r"<[?!][^>]*>", "", start))
        kind = {"map": "a TMX map (Tiled)", "svg": "an SVG image", "html": "an HTML page"}
        return kind.get(root[1].lower(), f"XML with the root {root[1]}") if root else "XML"
    if moving_ai.SCENARIO.match(text):
        return "a Moving AI scenario, which is read with the map beside it"
    if path.suffix.lower() in (".yaml", ".yml"):
        return "YAML without the key 'image', which one of ROS map_server has"
    if "@" in text and set(text) <= set(moving_ai.WALKED_ON + moving_ai.WALLS + "\n"):
        return "a Moving AI map without its header"
    if re.match(r"(#!|import |from \w+ import |def |class )", text):
        return "a program"
    return ""


def _remedy(kind: str) -> str:
    return next((remedy for word, remedy in REMEDIES.items() if word in kind), f"maps are {READ}")


# -- formats ------------------------------------------------------------------------------------------------------


def _moving_ai(text: str, options: MapOptions, path: Path) -> Drawing:
    drawing = moving_ai.read(text, str(path), MAX_CELLS)
    scenario = moving_ai.scenario_of(path)
    if (options.start and options.goals) or not scenario.is_file():
        return drawing
    return moving_ai.with_scenario(drawing, read_text(scenario), scenario.name)


def _ros(image: Path, content: bytes, settings: Path | None, options: MapOptions) -> Drawing:
    if not (content[:2] in (b"P2", b"P5") and content[2:3].isspace()):
        raise UserError(f"{image}: is no PGM image; save it as PGM and name it in {settings}")
    given = None if settings is None else _settings(settings)
    return ros.read(content, given, str(settings or image), cell=options.cell or None, max_cells=MAX_CELLS)


def _settings(path: Path) -> Mapping[str, Any]:
    import yaml  # slow to import, and most maps are texts

    try:
        settings = yaml.safe_load(read_text(path))
    except (yaml.YAMLError, ValueError) as error:
        raise UserError(f"{path}: is not YAML ({' '.join(str(error).split()):.200}); correct it there") from error
    if not isinstance(settings, dict) or not isinstance(settings.get("image"), str):
        raise UserError(f"{path}: does not name its image; add the line 'image: FILE.pgm'")
    return settings


def _own(text: str, options: MapOptions, path: Path) -> MapRead:
    """Read this package's text; a start and goals of the options replace its own."""
    if not (options.start or options.goals or options.seed is not None):
        return MapRead(GridWorld.from_text(text, str(path)), ())
    rows = text.rstrip("\n").split("\n")
    GridWorld.check_letters(rows, str(path))
    letters = np.array([list(row) for row in rows])
    goals = sorted((letter, _cell(letters == letter)) for letter in set(letters.flat) - {WALL, FREE, START})
    starts = letters == START
    for letter, cell in goals:
        if options.start and not options.goals and _option(cell) == "{},{}".format(*options.start):
            raise UserError(f"{path}: start: {shown(cell)} is goal {letter}; choose another cell, or goals as well")
    drawing = Drawing(letters != WALL, _cell(starts) if starts.any() else None, tuple(cell for _, cell in goals))
    if options.goals or not goals:
        return _placed(drawing, options, path, walls=False)
    return _placed(drawing, options, path, walls=False, names="".join(letter for letter, _ in goals))


def _cell(chosen: np.ndarray) -> Cell:
    row, column = np.argwhere(chosen)[0]
    return int(row), int(column)


# -- start and goals ----------------------------------------------------------------------------------------------


def _placed(drawing: Drawing, options: MapOptions, path: Path, *, walls: bool = True, names: str = GOALS) -> MapRead:
    """Put the start and the goals on a map.

    Parameters
    ----------
    walls : bool
        Whether free cells that the start does not reach become walls.
    names : str
        Letters of the goals.
    """
    name, free, notes = str(path), drawing.free, list(drawing.notes)
    if not free.any():
        raise UserError(f"{name}: has no free cell; a start and a goal need two")
    start = _asked(options.start, free, f"{name}: start") if options.start else drawing.start
    goals = [_asked(goal, free, f"{name}: goal") for goal in options.goals] or list(drawing.goals)
    if start in goals and not options.goals:
        goals.remove(start)
    places = [start, *goals] if start else goals
    for cell in places:
        if places.count(cell) > 1:
            raise UserError(f"{name}: {shown(cell)} is given twice among start and goals; give different cells")
    parts = _parts(free)
    random = np.random.Generator(np.random.SFC64(options.seed or 0))
    drawn = []
    if start is None:
        part = parts[goals[0]] if goals else np.bincount(parts[free]).argmax()
        start = _chosen(random, parts == part, goals, 1, name)[0]
        drawn.append(f"--start {_option(start)}")
    reached = parts == parts[start]
    given = bool(goals)
    if not given:
        goals = _by_distance(reached, start, _chosen(random, reached, [start], DRAWN_GOALS, name), name)
        drawn += [f"--goal {_option(goal)}" for goal in goals]
    if drawn:
        seed = options.seed or 0
        notes.append(f"drawn with seed {seed}: {' '.join(drawn)} (row,column from 1; --map-seed draws others)")
    if walls and (cut := np.count_nonzero(free & ~reached)):
        notes.append(f"{cut} free cells that the start does not reach are walls here")
        kept = reached
    else:
        kept = free
    letters = np.where(kept, FREE, WALL)
    for letter, cell in zip(names if given else GOALS, goals, strict=False):
        letters[cell] = letter
    letters[start] = START
    return MapRead(GridWorld(["".join(row) for row in letters], name), tuple(f"{name}: {note}" for note in notes))


def _option(cell: Cell) -> str:
    return f"{cell[0] + 1},{cell[1] + 1}"


def _asked(given: Sequence[int], free: np.ndarray, what: str) -> Cell:
    """Return a cell that was asked for, counted from 1."""
    row, column = given
    rows, columns = free.shape
    if not (1 <= row <= rows and 1 <= column <= columns):
        raise UserError(f"{what}: row {row}, column {column} is not on the map of {rows} rows and {columns} columns")
    if not free[row - 1, column - 1]:
        raise UserError(f"{what}: row {row}, column {column} is a wall; choose a free cell")
    return row - 1, column - 1


def _parts(free: np.ndarray) -> np.ndarray:
    """Return the number of the connected part of each free cell, 0 on walls."""
    from scipy.ndimage import label  # slow to import, and most maps do not need it

    return label(free)[0]


def _chosen(random: np.random.Generator, cells: np.ndarray, taken: list[Cell], number: int, name: str) -> list[Cell]:
    """Draw up to ``number`` of the cells that are not taken."""
    cells = cells.copy()
    for cell in taken:
        cells[cell] = False
    places = np.argwhere(cells)
    if not len(places):
        raise UserError(f"{name}: has no room for a start and a goal in one connected part")
    drawn = random.choice(len(places), min(number, len(places)), replace=False)
    return [(int(row), int(column)) for row, column in places[drawn]]


def _by_distance(free: np.ndarray, start: Cell, goals: list[Cell], name: str) -> list[Cell]:
    """Return goals in the order of their shortest path from the start."""
    letters = np.where(free, FREE, WALL)
    letters[start], letters[goals[0]] = START, GOALS[0]
    world = GridWorld(["".join(row) for row in letters], name)
    distance = world.distances_to(world.start)
    return sorted(goals, key=lambda goal: (distance[world.state_at(*goal)], goal))
