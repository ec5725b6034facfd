"""The documentation is right: links, commands, formats, and the code on its pages runs."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import click
import pandas as pd
import pytest
import yaml
from projects import MAPS, ROOT, TINY, Project, errors_of

import ptl
from ptl.cli import commands
from ptl.config import Parameters
from ptl.report import ledger
from ptl.report.readme import filled
from ptl.world.gridworld import load_map

PAGES = [
    path.relative_to(ROOT).as_posix()
    for path in (*ROOT.glob("*.md"), *ROOT.glob("docs/*.md"), ROOT / "config/README.md")
]

FENCE = re.compile(r"^```(\w*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)


def text_of(page: str) -> str:
    return (ROOT / page).read_text(encoding="utf-8")


def blocks(page: str, *languages: str) -> list[str]:
    """Fenced blocks of a page in these languages, in order."""
    return [code for language, code in FENCE.findall(text_of(page)) if language in languages]


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
    targets = re.findall(r"^([a-z-]+):", text_of("Makefile"), re.MULTILINE)
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


def write_files_of(page: str, folder: Path) -> list[Path]:
    """Write the files that a tutorial tells its reader to save; their names stand before the blocks."""
    written = []
    pattern = r"[Ss]ave this(?: one)? as\s+`([^`]+)`[^`]*?```\w*\n(.*?)^```$"
    for name, content in re.findall(pattern, text_of(page), re.MULTILINE | re.DOTALL):
        assert not (folder / name).exists(), f"{page}: {name} is there already"
        (folder / name).write_text(content, encoding="utf-8")
        written.append(folder / name)
    return written


def test_tutorials_add_only_their_own_jobs(tmp_path: Path) -> None:
    """Counted without running anything: the small run with both tutorials laid over it."""
    project = Project(tmp_path, None)
    write_files_of("docs/tutorial-your-own-map.md", tmp_path)
    write_files_of("docs/tutorial-your-own-method.md", tmp_path)
    jobs = project.waiting("--configfile", "config/smoke.yaml", "courtyard.yaml", "control.yaml")
    environments, methods, seeds, lives = 3 + 1, 6 + 1, 2, 2
    assert jobs["learn"] == environments * methods * seeds
    assert jobs["merge_survey"] == environments
    assert jobs["grow"] == lives


def run_tutorial(page: str, project: Project) -> dict[str, str]:
    """Do what a tutorial says, in its order; return what each command, and the Python code, printed."""
    assert write_files_of(page, project.folder)
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    printed = {}
    for language, code in FENCE.findall(text_of(page)):
        if language == "sh":
            for line in code.splitlines():
                done = subprocess.run(
                    line, shell=True, cwd=project.folder, env=project.environment | {"PATH": path},
                    capture_output=True, text=True,
                )  # fmt: skip
                assert done.returncode == 0, f"{line}\n{done.stdout}{done.stderr}"
                printed[line] = done.stdout + done.stderr
        elif language == "python" and "import pandas" in code:
            done = project.python("-c", code)
            assert done.returncode == 0, done.stderr
            printed["python"] = done.stdout
    return printed


@pytest.mark.slow
def test_map_tutorial_works(tmp_path: Path) -> None:
    printed = run_tutorial("docs/tutorial-your-own-map.md", Project(tmp_path, None))
    [dry] = [text for command, text in printed.items() if "--dry-run" in command]
    assert re.search(r"^learn +12$", dry, re.MULTILINE), dry
    assert not re.search(r"^grow ", dry, re.MULTILINE), dry
    methods = yaml.safe_load(text_of("config/config.yaml"))["methods"]
    assert all(method in printed["python"] for method in methods)
    reports = tmp_path / "reports/smoke"
    for figure in ("map", "discovery"):
        assert (reports / f"figures/{figure}_courtyard.png").stat().st_size > 0
    for number, title in ((1, "Environment 1"), (6, "Environment 3"), (7, "Courtyard"), (8, "Courtyard")):
        assert title in (reports / f"tables/table{number}.html").read_text(encoding="utf-8")
    for figure in ("figure08", "figure12"):
        assert "courtyard" in (reports / f"figures/{figure}.csv").read_text(encoding="utf-8")


@pytest.mark.slow
def test_method_tutorial_works(tmp_path: Path) -> None:
    printed = run_tutorial("docs/tutorial-your-own-method.md", Project(tmp_path, None))
    assert "random_skill" in printed["python"]
    reports = tmp_path / "reports/smoke"
    for number in range(1, 7):
        assert "Random skill" in (reports / f"tables/table{number}.html").read_text(encoding="utf-8")
    assert "random_skill" in (reports / "figures/figure12.csv").read_text(encoding="utf-8")
    per_seed = pd.read_csv(reports / "tables/per_seed.csv")
    assert (per_seed["method"] == "random_skill").sum() == 3 * 6 * 2


@pytest.mark.slow
def test_gymnasium_page_works(tmp_path: Path) -> None:
    project = Project(tmp_path, None)
    shutil.copytree(ROOT / "examples", tmp_path / "examples")
    printed = run_tutorial("docs/gymnasium.md", project)
    assert "gymnasium_sarsa" in printed["python"]
    reports = tmp_path / "reports/rivals"
    own = pd.read_csv(tmp_path / "sarsa.csv")
    per_seed = pd.read_csv(reports / "tables/per_seed.csv").set_index(["method", "task", "seed"]).sort_index()
    totals = own.groupby(["method", "task", "seed"])["steps"].sum()
    assert (per_seed.loc["gymnasium_sarsa", "total_steps"] == totals.loc["gymnasium_sarsa"]).all()
    first = own[own["episode"] == 1].set_index(["method", "task", "seed"]).sort_index()["steps"].loc["gymnasium_sarsa"]
    base = per_seed.loc["no_transfer", "first_episode"]
    assert (per_seed.loc["gymnasium_sarsa", "jump_start"] == base - first).all()
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
