"""The documentation is right: links, commands, formats, and the code on its pages runs."""

from __future__ import annotations

import os
import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

import click
import numpy as np
import pandas as pd
import pytest
import snakemake.cli
import yaml
from projects import MAPS, ROOT, TINY, Project, errors_of

import ptl
from ptl import methods
from ptl.cli import commands
from ptl.config import Parameters
from ptl.measures.exact import first_episode_without_transfer
from ptl.measures.run_files import read_steps
from ptl.report import ledger
from ptl.report.readme import filled
from ptl.world.map_files import load_map

PAGES = [
    path.relative_to(ROOT).as_posix()
    for path in (*ROOT.glob("*.md"), *ROOT.glob("docs/*.md"), ROOT / "config/README.md", ROOT / "reports/README.md")
]

RULES = [ROOT / "workflow/Snakefile", *(ROOT / "workflow/rules").glob("*.smk")]

FENCE = re.compile(r"^```(\w*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)


def text_of(page: str) -> str:
    """Text of a page, without the lines on studies that have been removed."""
    lines = (ROOT / page).read_text(encoding="utf-8").splitlines(keepends=True)
    gone = re.compile(r"studies/(\w+)|reports/(fv_check|multiverse|beyond)/|make (fv-check|multiverse|beyond)")
    there = {path.name for path in (ROOT / "studies").iterdir() if path.is_dir()}
    studies = [
        {(name or "").replace("-", "_") for match in gone.findall(line) for name in match} - {""} for line in lines
    ]
    return "".join(line for line, named in zip(lines, studies, strict=True) if named <= there)


def blocks(page: str, *languages: str) -> list[str]:
    """Fenced blocks of a page in these languages, in order."""
    return [code for language, code in FENCE.findall(text_of(page)) if language in languages]


def commands_of(language: str, code: str) -> list[str]:
    """Commands of a block: every line of a script, and the lines after the prompts of a session."""
    lines = code.splitlines()
    return lines if language == "sh" else [line[2:] for line in lines if language == "console" and line[:2] == "$ "]


def section(page: str, heading: str) -> str:
    """Text between a heading and the next one of any level."""
    found = re.search(rf"^#+ {re.escape(heading)}\n(.*?)(?=^#|\Z)", text_of(page), re.MULTILINE | re.DOTALL)
    assert found, f"{page} has no section {heading!r}"
    return found.group(1)


def first_column(table: str) -> set[str]:
    """Names in backticks in the first column of the Markdown tables of a text."""
    cells = re.findall(r"^\| (`[^|]*) \|", table, re.MULTILINE)
    return {name for cell in cells for name in re.findall(r"`([^`]+)`", cell)}


# -- links and names


def anchor(heading: str) -> str:
    return re.sub(r"[^\w\- ]", "", heading.strip().lower()).replace(" ", "-")


@pytest.mark.parametrize("page", PAGES)
def test_links_lead_somewhere(page: str) -> None:
    for target in re.findall(r"\]\(([^)\s]+)\)", FENCE.sub("", text_of(page))):
        if "://" in target:
            continue
        path, _, fragment = target.partition("#")
        file = (ROOT / page).parent / path if path else ROOT / page
        assert file.exists(), f"{page}: {target} leads nowhere"
        if fragment:
            headings = re.findall(r"^#+ (.*)$", file.read_text(encoding="utf-8"), re.MULTILINE)
            assert fragment in map(anchor, headings), f"{page}: {target} names no heading"


@pytest.mark.parametrize("page", PAGES)
def test_commands_that_are_named_exist(page: str) -> None:
    text = text_of(page)
    with click.Context(commands) as context:
        known = set(commands.list_commands(context))
    for name in re.findall(r"(?:^\s*\$? ?|`)ptl ([a-z][a-z-]+)", text, re.MULTILINE):
        assert name in known, f"{page}: there is no command 'ptl {name}'"
    makefiles = ["Makefile", *(path.relative_to(ROOT).as_posix() for path in ROOT.glob("studies/*/study.mk"))]
    targets = re.findall(r"^([a-z-]+)(?: [a-z-]+)*:", "\n".join(map(text_of, makefiles)), re.MULTILINE)
    for name in re.findall(r"(?:^\s*\$ |`)make ([a-z-]+)", text, re.MULTILINE):
        assert name in targets, f"{page}: there is no command 'make {name}'"


@pytest.mark.parametrize("page", PAGES)
def test_files_that_are_named_exist(page: str) -> None:
    text = text_of(page)
    known = {"ptl/GridWorld-v0", *re.findall(r"Save this(?: one)? as\s+`([^`]+)`", text)}  # to be made by the reader
    named = set(re.findall(r"`((?:ptl|docs|workflow|config|tests|examples|profiles)/[\w./-]+)`", text))
    modules = {name.replace(".", "/") for name in re.findall(r"`(ptl(?:\.[a-z_0-9]+)+)`", text)}
    missing = {name for name in named - known if not (ROOT / name).exists()}
    missing |= {
        name
        for name in modules
        if not any((ROOT / f"{part}{end}").exists() for part in (name, name.rpartition("/")[0]) for end in (".py", ""))
    }
    assert not missing, f"{page} names what is not there"


def test_results_in_the_readme_are_those_of_the_published_run() -> None:
    assert text_of("README.md") == filled(text_of("README.md"), ROOT / "reports/published"), "run: make docs"


# -- reconstruction


def test_reconstruction_names_every_hyper_parameter_value() -> None:
    """The page explains each value in its context."""
    page = text_of("docs/reconstruction.md")
    values = Parameters()
    for needed in (
        f"| learning rate α | {values.learning.alpha} |",
        f"| discount γ | {values.learning.gamma} |",
        f"| {values.learning.epsilon} | **[chosen]** |",
        f"| episodes in a task | {values.learning.episodes} |",
        rf"\sigma = {values.skills.prior_width}",
        rf"\kappa = {values.skills.likelihood_exponent:g}",
        rf"\beta = {values.skills.likelihood_weight}",
        f"$T = {values.subgoals.trajectories}$",
        f"$r = {values.subgoals.cover_radius}$",
        rf"$\rho = {values.subgoals.novelty}$",
        rf"$\theta = {values.subgoals.threshold}$",
        rf"\upsilon = {values.policy_reuse.psi_decay}",
        rf"\Delta\tau = {values.policy_reuse.temperature_step}",
    ):
        assert needed in page, f"docs/reconstruction.md no longer says {needed}"


def test_reconstruction_gives_the_sizes_of_the_maps(published_maps: dict) -> None:
    page = text_of("docs/reconstruction.md")
    for number, world in enumerate(published_maps.values(), start=1):
        assert f"**Environment {number}**, {world.n_states} states" in page


# -- architecture


def test_every_room_has_its_row() -> None:
    rooms = {path.parent.name + "/" for path in (ROOT / "ptl").glob("*/*.py")}
    modules = {path.name for path in (ROOT / "ptl").glob("*.py") if not path.name.startswith("__")}
    assert first_column(section("docs/architecture.md", "Rooms")) == rooms | modules


def test_diagram_shows_rules_that_depend_on_each_other() -> None:
    command = [sys.executable, "-m", "snakemake", "--rulegraph", "--forceall", "--nolock"]
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    names = dict(re.findall(r'(\d+)\[label = "(\w+)"', done.stdout))
    edges = {(names[a], names[b]) for a, b in re.findall(r"(\d+) -> (\d+)", done.stdout)}
    [diagram] = blocks("docs/architecture.md", "mermaid")
    shown = set(re.findall(r"(\w+) --> (\w+)", diagram))
    assert len(shown) > 5 and shown <= edges, f"take out {sorted(shown - edges)}"


# -- file format


@pytest.fixture(scope="module")
def small_run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a small run that has the names of the published one."""
    project = Project(
        tmp_path_factory.mktemp("run"),
        run="published",
        environments={"env2": {"map": "config/environments/env2.txt"}},
        learning={"episodes": 12},
        growth=TINY["growth"] | {"environment": "env2"},
        subgoal_frequencies={"trajectories": 2, "starts": 2, "batches": 1},
    )
    project.make("tables", "subgoal_frequencies")
    return project.folder


def test_examples_of_the_format_page_run(
    small_run: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(small_run)
    names: dict = {}
    for code in blocks("docs/file-format.md", "python"):
        exec(compile(code, "docs/file-format.md", "exec"), names)
    printed = capsys.readouterr().out
    assert "env2 ptl 0" in printed and f"{load_map(MAPS / 'env2.txt').n_states} states" in printed
    assert set(names["curves"]) == {"no_transfer", "policy_reuse", "ptl"}
    assert names["lives"].groupby(["seed", "task"]).size().tolist() == [12] * 12


def test_curves_are_redrawn_from_the_table_of_episodes(small_run: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(small_run)
    [code] = blocks("reports/README.md", "python")
    assert len([line for line in code.splitlines() if line]) == 5
    names: dict = {}
    exec(compile(code, "reports/README.md", "exec"), names)
    drawn = dict(zip(names["curves"].index.unique("method"), names["axes"].lines, strict=True))
    steps = read_steps("results/published/steps.h5")
    assert {*drawn} == {"no_transfer", "policy_reuse", "ptl"}
    for method, line in drawn.items():
        assert line.get_ydata() == pytest.approx(steps["env2", method, "F"].mean(axis=0))
    assert (small_run / "curves_env2.png").stat().st_size > 0


@pytest.mark.parametrize("name", ["per_seed.csv", "metrics.csv", "subgoals.csv", "growth.csv"])
def test_csv_columns_are_those_of_the_page(small_run: Path, name: str) -> None:
    frame = pd.read_csv(small_run / "reports/published/tables" / name)
    assert set(frame.columns) == first_column(section("docs/file-format.md", name))


def test_columns_of_the_verdicts_are_those_of_the_page() -> None:
    page = "docs/file-format.md"
    assert set(ledger.COLUMNS) == first_column(section(page, "claims.csv"))
    assert set(ledger.PART_COLUMNS) == first_column(section(page, "claims_parts.csv"))


# -- README and tutorials


def test_library_example_of_the_readme_runs(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(ROOT)
    [code] = blocks("README.md", "python")
    exec(compile(code, "README.md", "exec"), {})
    lines = capsys.readouterr().out.splitlines()
    assert [line[0] for line in lines] == list("ABCDEF")


COMMANDS = [
    (page, command)
    for page in PAGES
    for language, code in FENCE.findall(text_of(page))
    for command in commands_of(language, code)
    if command.startswith(("snakemake ", "ptl "))
]


@pytest.mark.parametrize(("page", "command"), COMMANDS)
def test_commands_of_the_pages_are_understood(page: str, command: str) -> None:
    """Their options are known, and no target is taken for something else."""
    program, *arguments = shlex.split(command, comments=True)
    if program == "ptl":
        with click.Context(commands) as context:
            name, called, rest = commands.resolve_command(context, arguments)
            called.make_context(name, rest)
        return
    _, given = snakemake.cli.parse_args(arguments)
    assert all(str(path).endswith(".yaml") for path in given.configfile or [])
    rules = set(re.findall(r"^\s*rule (\w+):", "".join(path.read_text() for path in RULES), re.MULTILINE))
    for target in given.targets:
        assert target in rules or target.startswith(("results/", "reports/"))


def run_page(page: str, where: Path, environment: Mapping[str, str]) -> dict[str, str]:
    """Follow a page's instructions in a folder, in order; return the output of each command and of the Python code."""
    environment = {**environment, "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"}
    text, end, printed = text_of(page), 0, {}

    def run(command: list[str], folder: Path) -> str:
        done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, timeout=500)
        assert done.returncode == 0, f"{command}\n{done.stdout}{done.stderr}"
        return done.stdout + done.stderr

    for block in FENCE.finditer(text):
        language, code = block.groups()
        before, end = text[end : block.start()], block.end()
        if saved := re.findall(r"[Ss]ave this(?: one)? as\s+`([^`]+)`", before):
            (where / saved[-1]).write_text(code, encoding="utf-8")
        elif language == "python":
            in_checkout = "config/environments" in code
            printed["python"] = run([sys.executable, "-c", code], ROOT if in_checkout else where)
        for command in commands_of(language, code):
            if command.startswith("cd "):
                where /= command.split()[1]
            elif not command.startswith(("source ", "pip ")):
                printed[command] = printed.get(command, "") + run(["bash", "-c", command], where)
    return printed


OUTSIDE = {**os.environ, "PYTHONPATH": str(ROOT)}
"""Environment of a reader who has the package installed and is somewhere else."""


@pytest.mark.slow
def test_map_tutorial_works(tmp_path: Path) -> None:
    printed = run_page("docs/tutorial-your-own-map.md", tmp_path, OUTSIDE)
    planned = re.findall(r"^learn +(\d+)$", printed["snakemake --dry-run --quiet rules"], re.MULTILINE)
    assert {int(number) for number in planned} == {6 * 2, 6 * (5 - 2)}
    reports = tmp_path / "my-maps/yard/reports/yard"
    for name in ("index.html", "explorer.html", "figures/map_courtyard.png", "figures/discovery_courtyard.png"):
        assert (reports / name).stat().st_size > 0
    assert "courtyard, task A (2 seeds: mean)" in printed["ptl metrics"]
    assert all(name in printed["python"] for name in methods.names())


@pytest.mark.slow
def test_method_tutorial_works(tmp_path: Path) -> None:
    run_page("docs/tutorial-your-own-method.md", tmp_path, OUTSIDE)
    reports = tmp_path / "my-methods/control/reports/control"
    for number in (1, 2):
        assert "Random skill" in (reports / f"tables/table{number}.html").read_text(encoding="utf-8")
    assert "random_skill" in (reports / "figures/curves.csv").read_text(encoding="utf-8")
    per_seed = pd.read_csv(reports / "tables/per_seed.csv")
    assert (per_seed["method"] == "random_skill").sum() == 4 * 2


@pytest.mark.slow
def test_gymnasium_page_works(tmp_path: Path) -> None:
    project = Project(tmp_path, None)
    shutil.copytree(ROOT / "examples", tmp_path / "examples")
    printed = run_page("docs/gymnasium.md", tmp_path, project.environment)
    assert "gymnasium_sarsa" in printed["python"]
    reports = tmp_path / "reports/rivals"
    own = pd.read_csv(tmp_path / "sarsa.csv")
    per_seed = pd.read_csv(reports / "tables/per_seed.csv").set_index(["method", "task", "seed"]).sort_index()
    totals = own.groupby(["method", "task", "seed"])["steps"].sum()
    assert (per_seed.loc["gymnasium_sarsa", "total_steps"] == totals.loc["gymnasium_sarsa"]).all()
    first = own[own["episode"] == 1].set_index(["method", "task", "seed"]).sort_index()["steps"].loc["gymnasium_sarsa"]
    world = load_map(MAPS / "env2.txt")
    base = first.index.get_level_values("task").map(
        lambda task: first_episode_without_transfer(world, world.goal(task))
    )
    np.testing.assert_allclose(per_seed.loc["gymnasium_sarsa", "jump_start"], base - first, rtol=1e-5)
    assert "Sarsa (Gymnasium)" in (reports / "tables/table1.html").read_text(encoding="utf-8")
    assert "gymnasium_sarsa" in (reports / "figures/figure12.csv").read_text(encoding="utf-8")
    (tmp_path / "sarsa.csv").write_text("environment,method\n")
    done = project.snakemake("--configfile", "rivals.yaml", "--", "reports/rivals/tables/metrics.csv")
    [line] = errors_of(done)
    assert "sarsa.csv: the columns 'environment,method' are not allowed" in line


# -- citation


def test_citation_names_version_licence_and_article() -> None:
    citation = yaml.safe_load(text_of("CITATION.cff"))
    assert {"cff-version", "message", "title", "authors"} <= set(citation)
    assert citation["version"] == ptl.__version__
    assert citation["license"] == "MIT" and text_of("LICENSE").startswith("MIT License")
    assert "10.1177/1729881419831555" in citation["message"] and "probably" in citation["abstract"]
    assert f"## {ptl.__version__}\n" in text_of("CHANGELOG.md")
