"""Variants of the reference maps in details that the article leaves open.

Changes are named ``<environment>.<kind>``, with the kinds

``start``     another start cell, [row, column] counted from 0,
``chain``     a chain of seven rooms, drawn with the parameters of `chain_of_rooms`,
``corridor``  a corridor with small rooms and one big room, drawn with the parameters of `corridor_with_rooms`,
``slip``      the probability that a step slips.

Those of a chain and a corridor draw a new map, regardless of that of the given world.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ptl.errors import UserError
from ptl.world.gridworld import GridWorld

ROOM_SIZE, GOAL_DEPTH = 10, 0.9
"""The values behind the map of environment 1."""

GOAL_ROW = 0.9
"""Row of every goal in its room of the chain, as a share of the room's height."""

KINDS = ("start", "chain", "corridor", "slip")


def changed_world(world: GridWorld, changes: Mapping[str, object]) -> GridWorld:
    """Return the world with changes, by kind; the world itself if there are none.

    Raises
    ------
    UserError
        For an unknown kind, or a value that makes no map.
    """
    unknown = set(changes) - set(KINDS)
    if unknown:
        raise UserError(f"{world.name}: cannot change {unknown.pop()!r}; known are {', '.join(KINDS)}")
    for kind, draw in (("chain", chain_of_rooms), ("corridor", corridor_with_rooms)):
        if kind in changes:
            world = GridWorld.from_text(draw(**changes[kind]), world.name, world.slip)  # type: ignore[arg-type, operator]
    if "start" in changes:
        world = with_start(world, changes["start"])  # type: ignore[arg-type]
    if "slip" in changes:
        world = world.with_slip(changes["slip"])  # type: ignore[arg-type]
    return world


def with_start(world: GridWorld, cell: Sequence[int]) -> GridWorld:
    """Return the same map with ``I`` in another free cell, (row, column) counted from 0."""
    row, column = (int(place) for place in cell)
    rows = [list(line.replace("I", ".")) for line in world.text.splitlines()]
    if not (0 <= row < len(rows) and 0 <= column < len(rows[0]) and rows[row][column] == "."):
        raise UserError(
            f"{world.name}: row {row}, column {column} (from 0) is not a free cell without a goal; choose another start"
        )
    rows[row][column] = "I"
    return GridWorld.from_text("\n".join(map("".join, rows)) + "\n", world.name, world.slip)


def chain_of_rooms(size: object = ROOM_SIZE, depth: object = GOAL_DEPTH, door: object = None, rooms: int = 7) -> str:
    """Return the text of environment 1's map with another room size and goal depth (the drawing is our choice).

    Rooms of ``size`` x ``size`` cells form a row with doors in the same place of every wall; room k + 1
    holds the k-th goal.

    Parameters
    ----------
    size : int
        Cells on a side, at least 4.
    depth : float
        Place of the goals from the wall with the door, as a share of ``size``, in (0, 1].
    door : float, optional
        Row of the doors as a share of ``size``, in (0, 1]; the row below the middle if left out.
    """
    if not (isinstance(size, int) and size >= 4):
        raise UserError(f"size: {size!r} is not allowed; give a whole number of at least 4")
    if not (isinstance(depth, int | float) and 0 < depth <= 1):
        raise UserError(f"depth: {depth!r} is not allowed; give a number in (0, 1]")
    if not (door is None or (isinstance(door, int | float) and 0 < door <= 1)):
        raise UserError(f"door: {door!r} is not allowed; give a number in (0, 1]")
    door_row = size // 2 + 1 if door is None else _share(size, float(door))
    goal_row = _share(size, GOAL_ROW)
    grid = [["#"] * (rooms * (size + 1) + 1) for _ in range(size + 2)]
    for room in range(rooms):
        left = room * (size + 1) + 1
        for row in range(1, size + 1):
            grid[row][left : left + size] = "." * size
        if room:
            grid[door_row][left - 1] = "."
            grid[goal_row][left + _share(size, depth) - 1] = chr(ord("A") + room - 1)
    grid[2][2] = "I"
    return "\n".join(map("".join, grid)) + "\n"


def corridor_with_rooms(width: int = 4, depth: int = 4, corridor: int = 2, big: Sequence[int] = (10, 9)) -> str:
    """Return the text of a map like environment 2: a corridor, four small rooms on either side, a big room at its end.

    The goals A to D are opposite the doors of their rooms, each further along the corridor; E and F are in the big room
    (the drawing is our choice).

    Parameters
    ----------
    width, depth : int
        Cells of a small room along the corridor and away from it, at least 2 and 1.
    corridor : int
        Width of the corridor in cells, at least 1.
    big : two int
        Rows and columns of the big room, which surrounds the end of the corridor.
    """
    rows, columns = (int(length) for length in big)
    if not (width >= 2 and depth >= 1 and corridor >= 1 and rows >= corridor and columns >= 3):
        raise UserError(
            f"corridor: width {width}, depth {depth}, corridor {corridor}, big {list(big)} make no map; give at least"
            " 2, 1, 1 and a big room no narrower than the corridor"
        )
    top = depth + 2  # first row of the corridor
    length = 4 * (width + 1) - 1
    first = max(1, top - (rows - corridor) // 2)  # first row of the big room
    height = max(top + corridor + depth + 2, first + rows + 1)
    grid = [["#"] * (length + columns + 3) for _ in range(height)]
    for row in range(top, top + corridor):
        grid[row][1 : length + 1] = "." * length
    for room in range(4):
        left = 1 + room * (width + 1)
        for row in range(1, depth + 1):
            grid[row][left : left + width] = "." * width
            grid[top + corridor + row][left : left + width] = "." * width
        grid[depth + 1][left + 1] = grid[top + corridor][left + 1] = "."
        goal_row = 1 if room % 2 == 0 else top + corridor + depth
        grid[goal_row][left + 1] = "ABCD"[room]
    big_left = length + 2
    grid[top][big_left - 1] = "."
    for row in range(first, first + rows):
        grid[row][big_left : big_left + columns] = "." * columns
    grid[max(first, top - 2)][big_left + columns - 2] = "E"
    grid[min(first + rows - 1, top + 1)][big_left + columns - 1] = "F"
    grid[top + corridor - 1][1] = "I"
    return "\n".join(map("".join, grid)) + "\n"


def _share(size: int, share: float) -> int:
    """Return the cell, counted from 1, at a share of the room's length."""
    return max(1, round(share * size))
