"""Maps of ROS map_server: a PGM image and a YAML file with its resolution and thresholds.

As in map_server, the occupancy of a pixel is 1 - value/maximum, or value/maximum with ``negate``; a pixel is free if
that is below ``free_thresh``. All else, occupied or unknown, is a wall. Map savers write 205 of 255 for unknown, and
newer ones a ``free_thresh`` of 0.25, under which 205 would be free (navigation2 issues 5138, 5278): 205 is never free.
"""

from __future__ import annotations

import re
import warnings
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from ptl.errors import UserError
from ptl.world.formats import Drawing

MAX_PIXELS = 2**24
"""Maximum size of an image."""

UNKNOWN = 205
"""Value of 255 that map savers write for an unknown pixel."""

DEFAULTS = {"negate": 0, "occupied_thresh": 0.65, "free_thresh": 0.196, "mode": "trinary"}
"""Settings of map_server that an image without a YAML file is read with."""

_NUMBER = re.compile(rb"(?:\s|#[^\n]*\n)*([0-9]+)")


def read(image: bytes, settings: Mapping[str, Any] | None, name: str, *, cell: float | None, max_cells: int) -> Drawing:
    """Read an image with the settings of its YAML file.

    Parameters
    ----------
    settings : mapping or None
        None if there is no YAML file.
    cell : float, optional
        Metres of a cell, a multiple of the resolution; by default a cell is a pixel. A cell is free if all of its
        pixels are.
    max_cells : int
    """
    given = {**DEFAULTS, **(settings or {})}
    thresholds = {key: _number(given[key], key, name, "a number from 0 to 1", lambda x: 0 <= x <= 1)
                  for key in ("free_thresh", "occupied_thresh")}  # fmt: skip
    if thresholds["free_thresh"] > thresholds["occupied_thresh"]:
        raise UserError(
            f"{name}: free_thresh {given['free_thresh']} exceeds occupied_thresh {given['occupied_thresh']};"
            " correct one of them"
        )
    if given["mode"] not in ("trinary", "scale"):
        raise UserError(f"{name}: mode {_shown(given['mode'])} is not read; give trinary or scale")
    negate = _number(given["negate"], "negate", name, "0 or 1", lambda x: x in (0, 1))
    values, maximum = read_pgm(image, name)
    occupancy = values / maximum if negate else 1 - values / maximum
    unknown = np.abs(values - UNKNOWN / 255 * maximum) <= max(1, maximum / 255) / 2  # rounded to the image's depth
    free = (occupancy < thresholds["free_thresh"]) & ~unknown
    occupied = occupancy > thresholds["occupied_thresh"]
    rows, columns = free.shape
    notes = [
        f"{rows} x {columns} pixels: {np.count_nonzero(free)} free, {np.count_nonzero(occupied & ~unknown)} occupied,"
        f" {np.count_nonzero(~free & (unknown | ~occupied))} unknown; only free ones are walked on"
    ]
    if settings is None:
        notes.append("no YAML file beside the image: read with the defaults of map_server")
    resolution = None
    if settings is not None and "resolution" in settings:
        resolution = _number(settings["resolution"], "resolution", name, "metres of a pixel, above 0", lambda x: x > 0)
    if cell is not None:
        free = _merged(free, _pixels_of_a_cell(cell, resolution, name))
    if free.size > max_cells:
        merged = int(np.ceil(np.sqrt(free.size / max_cells))) * (cell or resolution or 0)
        wanted = f", say {merged:g}" if merged else ""
        raise UserError(
            f"{name}: the map has {free.size} cells, more than {max_cells}; merge pixels with --cell METRES{wanted}"
        )
    return Drawing(free, notes=tuple(notes))


def read_pgm(content: bytes, name: str) -> tuple[np.ndarray, int]:
    """Read a grey image (P2 or P5) as integers, shape (rows, columns), and the greatest value it may have."""
    place, header = 2, []
    for what in ("width", "height", "maximum"):
        match = _NUMBER.match(content, place)
        if match is None or len(match[1]) > 9 or int(match[1]) == 0:
            raise UserError(f"{name}: has no {what} where the header of a PGM image has it; save the image again")
        header.append(int(match[1]))
        place = match.end()
    width, height, maximum = header
    if width * height > MAX_PIXELS:
        raise UserError(f"{name}: has {width} x {height} pixels, more than {MAX_PIXELS}; use a smaller image")
    if maximum > 65535:
        raise UserError(f"{name}: maximum {maximum} is not allowed in a PGM image; save it with 255")
    if content[:2] == b"P2":
        with warnings.catch_warnings():
            warnings.simplefilter("error")  # numpy's sign that there is something else than numbers
            try:
                values = np.fromstring(re.sub(rb"#[^\n]*", b"", content[place:]).decode("latin-1"), np.int64, sep=" ")
            except (DeprecationWarning, ValueError):
                raise UserError(f"{name}: has something else than numbers among its pixels; save it again") from None
    else:
        kind = np.dtype(np.uint8 if maximum < 256 else ">u2")
        least = place + 2 + width * height * kind.itemsize
        ends = 2 if content[place : place + 2] == b"\r\n" and len(content) >= least else 1
        raster = content[place + ends :]  # one white space ends the header, or one line end
        values = np.frombuffer(raster[: len(raster) // kind.itemsize * kind.itemsize], kind)
    if len(values) < width * height or (content[:2] == b"P2" and len(values) > width * height):
        raise UserError(
            f"{name}: width {width} and height {height} make {width * height} pixels, but there are {len(values)};"
            " save the image again"
        )
    values = values[: width * height].reshape(height, width)
    if values.max() > maximum or values.min() < 0:
        wrong = values[(values > maximum) | (values < 0)][0]
        raise UserError(f"{name}: pixel {wrong} is not from 0 to the image's maximum {maximum}; save the image again")
    return values, maximum


def _number(value: Any, key: str, name: str, wanted: str, fits: Callable[[float], bool]) -> float:
    try:
        number = float(value)  # a text such as 5e-2, which YAML 1.1 takes for one, too
    except (TypeError, ValueError):
        number = float("nan")
    if not fits(number) or not np.isfinite(number):
        raise UserError(f"{name}: {key} {_shown(value)} is not allowed; give {wanted}")
    return number


def _shown(value: Any) -> str:
    return "without a value" if value is None else f"{value!r:.60}"


def _pixels_of_a_cell(cell: float, resolution: float | None, name: str) -> int:
    if resolution is None:
        raise UserError(f"{name}: --cell needs the resolution of the image, which its YAML file has")
    number = round(cell / resolution)
    if number < 1 or abs(number * resolution - cell) > 1e-6 * cell:
        low = max(1, int(cell / resolution))
        raise UserError(
            f"{name}: --cell {cell:g} is no multiple of the resolution {resolution:g}; give {low * resolution:g} or"
            f" {(low + 1) * resolution:g}"
        )
    return number


def _merged(free: np.ndarray, number: int) -> np.ndarray:
    """Merge squares of pixels; a square that leaves the image is not free there."""
    rows, columns = (-(-length // number) * number for length in free.shape)
    padded = np.zeros((rows, columns), dtype=bool)
    padded[: free.shape[0], : free.shape[1]] = free
    return np.asarray(padded.reshape(rows // number, number, columns // number, number).all(axis=(1, 3)))
