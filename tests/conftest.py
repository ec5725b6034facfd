"""Fixtures shared by all tests: the three published maps."""

from __future__ import annotations

from pathlib import Path

import pytest

from ptl.gridworld import GridWorld, load_map

MAPS = Path(__file__).resolve().parent.parent / "config" / "environments"


@pytest.fixture(scope="session")
def env1() -> GridWorld:
    """Environment 1 of the article: seven rooms in a row."""
    return load_map(MAPS / "env1.txt")


@pytest.fixture(scope="session")
def env2() -> GridWorld:
    """Environment 2 of the article: a corridor with small rooms and one big room."""
    return load_map(MAPS / "env2.txt")


@pytest.fixture(scope="session")
def env3() -> GridWorld:
    """Environment 3 of the article: the map of Fernandez and Veloso."""
    return load_map(MAPS / "env3.txt")


@pytest.fixture(scope="session")
def published_maps(env1: GridWorld, env2: GridWorld, env3: GridWorld) -> dict[str, GridWorld]:
    """The three environments by name."""
    return {"env1": env1, "env2": env2, "env3": env3}
