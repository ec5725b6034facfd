"""Fixtures shared by all tests: the three published maps, a tiny run and a browser."""

from __future__ import annotations

import fcntl
import os
import shutil
from collections.abc import Iterator
from typing import Any

import pytest
from projects import MAPS, Project

from ptl.world.gridworld import GridWorld
from ptl.world.map_files import load_map


def pytest_configure() -> None:
    """Forget `make test`: a make that a test starts is a user's first, and prints what that prints."""
    for name in ("MAKEFLAGS", "MAKELEVEL", "MFLAGS"):
        os.environ.pop(name, None)


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


@pytest.fixture(scope="session")
def tiny(tmp_path_factory: pytest.TempPathFactory) -> Project:
    """A copy of the checkout in which everything has been made; a test that changes it puts it back."""
    base = tmp_path_factory.getbasetemp()
    made = (base.parent if "PYTEST_XDIST_WORKER" in os.environ else base) / "tiny-made"
    with made.with_suffix(".lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)  # one worker makes it, the others wait
        if not made.is_dir():
            project = Project(tmp_path_factory.mktemp("tiny-making"))
            project.make()
            project.folder.rename(made)
    return Project.copy_of(made, tmp_path_factory.mktemp("tiny") / "copy")


CHROMIUM_FLAGS = (
    "--headless --no-sandbox --disable-gpu --disable-quic --no-first-run --disable-background-networking"
    " --disable-component-update --disable-sync --disable-default-apps --disable-extensions"
)


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    """A headless Chromium that logs its console and its requests."""
    from selenium import webdriver
    from selenium.webdriver.chrome.service import Service

    programs = [shutil.which(name) for name in ("chromium", "chromedriver")]
    if None in programs:
        pytest.fail(
            "the browser tests need chromium and chromedriver (apt-get install chromium chromium-driver);"
            " leave them out with -m 'not browser'"
        )
    options = webdriver.ChromeOptions()
    options.binary_location = programs[0]
    for flag in (*CHROMIUM_FLAGS.split(), f"--user-data-dir={tmp_path_factory.mktemp('profile')}"):
        options.add_argument(flag)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    driver = webdriver.Chrome(options=options, service=Service(programs[1]))
    yield driver
    driver.quit()
