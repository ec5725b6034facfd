"""The workflow as a module of users' Snakefiles: renamed rules, a prefix, a hosted source, another folder."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pandas as pd
import pytest
import yaml
from projects import ROOMS, ROOT

CONFIG = """
run: m
methods: [no_transfer, ptl]
environments: {rooms: {map: rooms.txt}}
seeds: 2
learning: {episodes: 10}
statistics: {resamples: 100}
growth: {runs: 0}
subgoal_frequencies: {starts: 0}
"""
SNAKEFILE = """
from ptl.deployment import SNAKEFILE
configfile: "config.yaml"
module ptl:
    snakefile: %s
    config: config%s
use rule * from ptl%s
"""


def study(folder: Path, source: str = "SNAKEFILE", more: str = "", name: str = "") -> Path:
    folder.mkdir()
    (folder / "rooms.txt").write_text(ROOMS)
    (folder / "config.yaml").write_text(CONFIG)
    (folder / "Snakefile").write_text(SNAKEFILE % (source, more, name))
    return folder


def snakemake(folder: Path, *arguments: str | Path, fails: bool = False) -> str:
    command = [sys.executable, "-m", "snakemake", "-j2", *map(str, arguments)]
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, timeout=600)
    assert (done.returncode != 0) == fails, done.stderr[-4000:]
    return done.stdout + done.stderr


def check_whole(folder: Path) -> None:
    per_seed = pd.read_csv(folder / "reports/m/tables/per_seed.csv")
    assert len(per_seed) == 2 * 2 * 2 and (folder / "reports/m/manifest.json").exists()


@pytest.mark.slow
def test_renamed_rules_under_a_prefix_make_everything_once(tmp_path: Path) -> None:
    folder = study(tmp_path / "own", more='\n    prefix: "sub"', name=" as ptl_*")
    snakemake(folder)
    check_whole(folder / "sub")
    assert not {"results", "reports", "logs"} & {path.name for path in folder.iterdir()}
    assert "Nothing to be done" in snakemake(folder)
    shutil.rmtree(folder / ".snakemake")
    assert "Nothing to be done" in snakemake(folder)
    assert "ptl_learn" in snakemake(folder, "-n", "--config", "seeds=3")


@pytest.mark.slow
def test_a_hosted_snakefile_runs_with_the_rules_of_the_package(tmp_path: Path) -> None:
    hosted = tmp_path / "hosted"
    shutil.copytree(ROOT / "workflow", hosted / "workflow")
    git = ["git", "-C", str(hosted), "-c", "user.name=a", "-c", "user.email=a@localhost"]
    for command in (["init", "-q"], ["add", "."], ["commit", "-qm", "Add workflow"]):
        subprocess.run([*git, *command], check=True)
    folder = study(tmp_path / "own", f'"git+file://{hosted}/workflow/Snakefile@HEAD"')
    snakemake(folder)
    check_whole(folder)
    assert "Nothing to be done" in snakemake(tmp_path, "--snakefile", folder / "Snakefile", "--directory", folder)


def test_replaced_prefixes_are_refused_in_a_line(tmp_path: Path) -> None:
    folder = study(tmp_path / "own", more='\n    replace_prefix: {"results/": "out/"}')
    assert "error: replace_prefix: is not supported; give the module a prefix" in snakemake(folder, "-n", fails=True)


def test_a_configuration_elsewhere_is_read_and_maps_are_looked_for_where_the_workflow_runs(tmp_path: Path) -> None:
    folder = study(tmp_path / "own")
    (folder / "config.yaml").rename(tmp_path / "other.yaml")
    (folder / "Snakefile").write_text((folder / "Snakefile").read_text().replace('configfile: "config.yaml"', ""))
    arguments = ("-n", "--snakefile", folder / "Snakefile", "--configfile", tmp_path / "other.yaml")
    assert "learn" in snakemake(tmp_path, *arguments, "--directory", folder)
    assert "error: rooms.txt: cannot be read" in snakemake(tmp_path, *arguments, fails=True)


def test_the_conda_environment_names_the_packages_of_the_project() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    wanted = {re.split("[<>= ]", name)[0] for name in project["dependencies"]} - {"snakemake"}  # which makes it
    given = yaml.safe_load((ROOT / "workflow/envs/ptl.yaml").read_text())["dependencies"]
    names = {name.split()[0].removesuffix("-base") for name in given}
    assert names - {"python", "c-compiler", "pip", "cython"} == wanted


def test_a_checkout_keeps_its_bytes(tmp_path: Path) -> None:
    """Whatever git is told about line ends."""
    source = tmp_path / "source"
    source.mkdir()
    for name in (".gitattributes", "reports/published/tables/table1.csv", ".ci/run", "config/config.yaml"):
        (source / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / name, source / name)
    git = ["git", "-c", "user.name=a", "-c", "user.email=a@localhost", "-c", "core.autocrlf=true"]
    for command in (["init", "-q"], ["add", "."], ["commit", "-qm", "Add files"]):
        subprocess.run([*git, "-C", source, *command], check=True)
    subprocess.run([*git, "clone", "-q", source, tmp_path / "clone"], check=True)
    for path in (path for path in source.rglob("*") if path.is_file() and ".git" not in path.parts):
        assert (tmp_path / "clone" / path.relative_to(source)).read_bytes() == path.read_bytes()
