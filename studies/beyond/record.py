"""The Croissant record of the population of maps, which ``ptl docs`` writes beside the table."""

from __future__ import annotations

from pathlib import Path

from ptl.report.records import croissant

TABLE = Path(__file__).parent / "config/population.csv"
RECORD = TABLE.with_suffix(".croissant.json")

COLUMNS = {
    "band": ("sc:Text", "tuning or test; the bands have no map in common"),
    "family": ("sc:Text", "generator: chain of rooms, random rooms, perfect maze, braided maze, cave or open ground"),
    "size": ("sc:Integer", "wanted number of states"),
    "seed": ("sc:Integer", "seed of the map"),
    "states": ("sc:Integer", "number of free cells"),
    "shortest_paths": ("sc:Text", "steps from the start to each of the six goals, separated by blanks"),
    "winding": ("sc:Float", "mean over the goals of shortest path / straight line, both from the start"),
    "hash": ("sc:Text", "first 16 hexadecimal digits of the SHA-256 of the map's text"),
}


def record() -> str:
    """Return the record as JSON-LD."""
    return croissant(
        TABLE,
        "grid-world-maps",
        "Generated grid-world mazes with a start and six goals each, for the comparison of methods that learn"
        " navigation tasks one after another. 'python -m studies.beyond.population --maps FOLDER' writes the maps as"
        " text.",
        COLUMNS,
    )
