"""An account without home, name or threads: a run works or ends in one line, and touches its folder only."""

from __future__ import annotations

import getpass
import threading

import pytest
from projects import Project

from ptl.cli.workflow import environment
from ptl.errors import UserError


def refuse(*_):
    raise KeyError("getpwuid(): uid not found: 12345")


def test_an_account_without_home_and_name_gets_them(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name in ("HOME", "XDG_CACHE_HOME", "MPLCONFIGDIR"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(getpass, "getuser", refuse)
    found = environment()
    assert found["LOGNAME"].startswith("uid")
    assert all(found[name].startswith(str(tmp_path)) for name in ("HOME", "XDG_CACHE_HOME", "MPLCONFIGDIR"))


def test_what_the_account_has_is_kept(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("HOME", "/home/of/someone")
    monkeypatch.setenv("XDG_CACHE_HOME", "/cache")
    found = environment()
    assert (found["HOME"], found["XDG_CACHE_HOME"]) == ("/home/of/someone", "/cache")


def test_braces_in_the_path_are_refused(tmp_path, monkeypatch):
    (tmp_path / "a{b}").mkdir()
    monkeypatch.chdir(tmp_path / "a{b}")
    with pytest.raises(UserError, match="takes braces in a path for wildcards"):
        environment()


def test_an_account_that_may_not_start_threads_is_refused(monkeypatch):
    started = []

    def start(thread, begin=threading.Thread.start):
        if len(started) == 3:
            raise RuntimeError("can't start new thread")
        started.append(thread)
        begin(thread)

    monkeypatch.setattr(threading.Thread, "start", start)
    with pytest.raises(UserError, match="can't start new thread: a run needs 8 threads"):
        environment()
    assert not any(thread.is_alive() for thread in started)


def test_a_run_touches_nothing_outside_its_folder(tmp_path):
    project, home = Project(tmp_path / "project"), tmp_path / "home"
    home.mkdir()
    variables = {name: value for name, value in project.environment.items() if name != "XDG_CACHE_HOME"}
    done = project.ptl("workflow", "-j2", "reports/tiny/figures/map_rooms.png", env=variables | {"HOME": str(home)})
    assert done.returncode == 0, done.stderr[-2000:]
    assert list(home.rglob("*")) == []
