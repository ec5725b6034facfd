"""The documentation says what is there: links, keys, formats, rules and the code on its pages."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import click
import h5py
import pandas as pd
import pytest
import yaml

import ptl
from ptl.claims import ledger
from ptl.cli import commands
from ptl.configuration_docs import document, document_file
from ptl.errors import UserError
from ptl.parameters import Parameters

ROOT = Path(__file__).resolve().parent.parent
PAGES = [
    "README.md",
    "CHANGELOG.md",
    "config/README.md",
    *(f"docs/{p.name}" for p in (ROOT / "docs").glob("*.md")),
]
SCHEMA = ROOT / "workflow/schemas/config.schema.yaml"
PUBLISHED = ROOT / "reports/published"

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


def test_no_place_is_left_to_be_filled() -> None:
    for page in PAGES:
        left = [
            comment
            for comment in re.findall(r"<!-- published:.*?-->", text_of(page))
            if not comment.endswith((", begin -->", ", end -->"))
        ]
        assert not left, f"{page}: fill in {left} from reports/published"


def verdict_table(claims: pd.DataFrame) -> str:
    """The summary of the verdicts that stands in the README."""
    lines = ["| verdict | number | claims |", "|---|---|---|"]
    for verdict in ("reproduced", "partly reproduced", "not reproduced", "undecided"):
        names = claims.loc[claims["verdict"] == verdict, "id"]
        if len(names):
            lines.append(f"| {verdict} | {len(names)} | {', '.join(names)} |")
    return "\n".join(lines)


def test_readme_sums_up_the_published_verdicts() -> None:
    claims = pd.read_csv(PUBLISHED / "claims.csv")
    expected = verdict_table(claims)
    assert len(re.findall(r"^\| .*reproduced|^\| undecided", expected, re.MULTILINE)) > 0
    begin, end = (f"<!-- published: verdicts, {word} -->" for word in ("begin", "end"))
    shown = text_of("README.md").partition(begin)[2].partition(end)[0].strip()
    assert shown == expected, f"put this between the marks of README.md:\n\n{expected}"


def speed_table(benchmark: pd.DataFrame) -> str:
    """The benchmark's figures that stand in the README."""
    machine = benchmark[benchmark["part"] == "machine"].set_index("item")["quantity"]
    speed = benchmark[benchmark["part"] == "speed"]
    run = benchmark[benchmark["item"] == "whole run"].set_index("quantity")["value"]
    lines = ["| learner | million steps with update per CPU second | times plain Python |", "|---|---|---|"]
    for learner, rows in speed.groupby("item", sort=False):
        rate, ratio = rows["value"]
        figures = [f"{value:.0f}" if value >= 10 else f"{value:.2g}" for value in (rate / 1e6, ratio)]
        lines.append(f"| {learner} | {figures[0]} | {figures[1]} |")
    minutes, seconds = divmod(round(run["wall seconds"]), 60)
    lines += [
        "",
        f"Measured on {machine['processor']}, {machine['cores']} cores, {machine['memory']}. There the whole run, all"
        f" tables and figures included, took {minutes} min {seconds} s.",
    ]
    return "\n".join(lines)


def test_readme_shows_the_published_speed() -> None:
    expected = speed_table(pd.read_csv(PUBLISHED / "benchmark.csv"))
    begin, end = (f"<!-- published: speed, {word} -->" for word in ("begin", "end"))
    shown = text_of("README.md").partition(begin)[2].partition(end)[0].strip()
    assert shown == expected, f"put this between the marks of README.md:\n\n{expected}"


# -- configuration


def test_configuration_page_is_that_of_the_schema() -> None:
    expected = document_file(SCHEMA)
    assert text_of("config/README.md") == expected, (
        "run: ptl config-docs workflow/schemas/config.schema.yaml --output config/README.md"
    )


def keys_of(schema: dict, prefix: str = "") -> Iterator[str]:
    for name, part in schema.get("properties", {}).items():
        yield f"{prefix}{name}"
        yield from keys_of(part, f"{prefix}{name}.")
    if isinstance(free := schema.get("additionalProperties"), dict):
        yield from keys_of(free, f"{prefix}<name>.")


def test_every_key_of_the_schema_is_documented() -> None:
    schema = yaml.safe_load(SCHEMA.read_text(encoding="utf-8"))
    page = text_of("config/README.md")
    for key in keys_of(schema):
        assert f"| `{key}` |" in page or f"## {key}\n" in page or f"`{key}." in page, key


def test_a_key_is_described_with_its_range_default_and_mark() -> None:
    rate = {"type": "number", "exclusiveMinimum": 0, "maximum": 1, "default": 0.5}
    name = {"type": "string", "pattern": "^a|b$"}
    schema = {
        "properties": {
            "rate": rate | {"description": "A rate [source, Somebody]."},
            "name": name | {"description": "A name."},
        },
        "required": ["name"],
    }
    page = document(schema)
    assert "| `rate` | A rate. | number > 0 and ≤ 1 | `0.5` | source (Somebody) |\n" in page
    assert "| `name` | A name. | text like `^a\\|b$` | required | – |\n" in page


def test_a_key_without_description_is_refused() -> None:
    with pytest.raises(UserError, match="schema key rate: has no description"):
        document({"properties": {"rate": {"type": "number"}}})


def test_defaults_agree_everywhere() -> None:
    """Schema, published configuration and Python give the same values."""
    properties = yaml.safe_load(SCHEMA.read_text(encoding="utf-8"))["properties"]
    published = yaml.safe_load(text_of("config/config.yaml"))
    for group, part in properties.items():
        for key, entry in part.get("properties", {}).items():
            assert published[group][key] == entry["default"], f"{group}.{key}"
    for group, values in Parameters().to_dict().items():
        assert values == published[group], group


# -- reconstruction


def test_reconstruction_names_every_hyper_parameter_value() -> None:
    """A default that changes must not leave the page behind."""
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


def snakemake(*arguments: str | Path, folder: Path = ROOT) -> subprocess.CompletedProcess[str]:
    """Run Snakemake in a folder with the package that lies there."""
    environment = os.environ | {"PYTHONPATH": str(folder)}
    return subprocess.run(
        [sys.executable, "-m", "snakemake", "-j2", *map(str, arguments)],
        cwd=folder, env=environment, capture_output=True, text=True,
    )  # fmt: skip


def test_rule_graph_is_that_of_the_workflow() -> None:
    result = snakemake("--rulegraph", "--forceall", "--nolock", "--configfile", "config/smoke.yaml")
    assert result.returncode == 0, result.stderr
    names = dict(re.findall(r'(\d+)\[label = "(\w+)"', result.stdout))
    edges = {(names[a], names[b]) for a, b in re.findall(r"(\d+) -> (\d+)", result.stdout)}
    assert len(edges) > 5
    [diagram] = blocks("docs/architecture.md", "mermaid")
    shown = set(re.findall(r"(\w+) --> (\w+)", diagram))
    wanted = {edge for edge in edges if not {"all", "manifest"} & set(edge)}
    assert shown == wanted, f"add {sorted(wanted - shown)}, take out {sorted(shown - wanted)}"
    drawn = set(re.findall(r"^    (\w+)", diagram, re.MULTILINE)) | {name for edge in shown for name in edge}
    assert drawn == set(names.values()) - {"all", "manifest"}


def test_every_module_has_its_room_on_the_page() -> None:
    listed = first_column(section("docs/architecture.md", "Rooms"))
    there = {path.name for path in (ROOT / "ptl").glob("[!_]*.py")} | {"__main__.py"}
    there |= {path.name for pattern in ("*.pyx", "*.pxd") for path in (ROOT / "ptl").glob(pattern)}
    there |= {f"{path.parent.name}/" for path in (ROOT / "ptl").glob("[!_]*/__init__.py")}
    assert listed == there, f"add {sorted(there - listed)}, take out {sorted(listed - there)}"


# -- file format


@pytest.fixture(scope="module")
def small_run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the files of a small run, made by the commands that the workflow calls."""
    folder = tmp_path_factory.mktemp("run")
    world = ROOT / "config/environments/env2.txt"
    fixed = ["--map", world, "--environment", "env2", "--root-seed", 1]
    brief = json.dumps({"learning": {"episodes": 12}})
    results, tables = Path("results/published"), Path("reports/published/tables")

    def call(*arguments: object) -> None:
        commands.main([str(argument) for argument in arguments], standalone_mode=False)

    before = Path.cwd()
    os.chdir(folder)
    try:
        files = []
        for method in ("no_transfer", "policy_reuse", "ptl"):
            for seed in range(2):
                files.append(results / f"learning/env2/{method}/seed_{seed:03d}.h5")
                call("learn", *fixed, "--tasks", "ABCDEF", "--method", method, "--seed", seed,
                     "--parameters", brief, "--output", files[-1])  # fmt: skip
        growth, frequencies = results / "growth/run_000.h5", results / "subgoal_frequencies/env2.h5"
        call("grow", *fixed, "--tasks", 3, "--run", 0, "--parameters", brief, "--output", growth)
        call("survey", "batch", *fixed, "--batch", 0, "--batches", 1, "--starts", 2, "--trajectories", 2,
             "--output", "batch.h5")  # fmt: skip
        call("survey", "merge", "batch.h5", "--output", frequencies)
        window = ["--window", 5, "--threshold-factor", 1.5]
        call("measure", *files, *window, "--output-per-seed", tables / "per_seed.csv", "--output-steps",
             results / "steps.h5", "--output-subgoals", tables / "subgoals.csv")  # fmt: skip
        call("tables", tables / "per_seed.csv", *window, "--output-metrics", tables / "metrics.csv",
             "--output-folder", tables, "--confidence", 0.95, "--resamples", 100)  # fmt: skip
        call("collect-growth", growth, "--output", tables / "growth.csv")
    finally:
        os.chdir(before)
    return folder


def test_examples_of_the_format_page_run(
    small_run: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(small_run)
    names: dict = {}
    for code in blocks("docs/file-format.md", "python"):
        exec(compile(code, "docs/file-format.md", "exec"), names)
    printed = capsys.readouterr().out
    assert "env2 ptl 0" in printed and "243 states" in printed
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


def test_hdf5_names_are_those_of_the_page(small_run: Path) -> None:
    page = "docs/file-format.md"
    results = small_run / "results/published"
    origin = first_column(section(page, "Origin"))
    found = set()
    names = {"learning/env2/ptl/seed_000.h5": "Learning files", "growth/run_000.h5": "Growth files",
             "subgoal_frequencies/env2.h5": "Frequency files"}  # fmt: skip
    for path, heading in names.items():
        listed = first_column(section(page, heading))
        with h5py.File(results / path) as file:
            found |= set(file.attrs)
            if "tasks" in file:
                library, task = set(file["library"]), file["tasks/A"]
                assert listed == library | set(task) | set(task.attrs)
            else:
                assert listed == set(file) - {"library"}
    assert found == origin


# -- README and tutorials


def test_library_example_of_the_readme_runs(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(ROOT)
    [code] = blocks("README.md", "python")
    exec(compile(code, "README.md", "exec"), {})
    lines = capsys.readouterr().out.splitlines()
    assert [line[0] for line in lines] == list("ABCDEF")


@pytest.fixture
def checkout(tmp_path: Path) -> Path:
    """A copy of the package and its workflow, without results."""
    for name in ("Snakefile", "config", "profiles", "ptl", "workflow"):
        source = ROOT / name
        if source.is_dir():
            shutil.copytree(source, tmp_path / name, ignore=shutil.ignore_patterns("__pycache__", "*.c"))
        else:
            shutil.copy(source, tmp_path / name)
    return tmp_path


def write_files_of(page: str, folder: Path) -> list[Path]:
    """Write the files that a tutorial tells its reader to save; their names stand before the blocks."""
    written = []
    pattern = r"[Ss]ave this(?: one)? as\s+`([^`]+)`[^`]*?```\w*\n(.*?)^```$"
    for name, content in re.findall(pattern, text_of(page), re.MULTILINE | re.DOTALL):
        assert not (folder / name).exists(), f"{page}: {name} is there already"
        (folder / name).write_text(content, encoding="utf-8")
        written.append(folder / name)
    return written


def test_tutorials_add_only_their_own_jobs(checkout: Path) -> None:
    """Counted without running anything: the small run with both tutorials laid over it."""
    write_files_of("docs/tutorial-your-own-map.md", checkout)
    write_files_of("docs/tutorial-your-own-method.md", checkout)
    overlays = ("config/smoke.yaml", "courtyard.yaml", "control.yaml")
    result = snakemake("--dry-run", "--printshellcmds", "--configfile", *overlays, folder=checkout)
    printed = result.stdout + result.stderr
    assert result.returncode == 0, printed
    jobs = dict(re.findall(r"^(\w+) +(\d+)$", printed, re.MULTILINE))
    environments, methods, seeds, lives = 3 + 1, 6 + 1, 2, 2
    assert int(jobs["learn"]) == environments * methods * seeds
    assert int(jobs["merge_survey"]) == environments
    assert int(jobs["grow"]) == lives
    [tables] = re.findall(r"^.* tables \S*per_seed\.csv .*$", printed, re.MULTILINE)
    order = re.findall(r"--environment '?(\w+)=", tables)
    assert order == ["env1", "env2", "env3", "courtyard"], "the article's tables must keep their numbers"


def run_tutorial(page: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> dict[str, str]:
    """Do what a tutorial says, in its order; return what each command, and the Python code, printed."""
    monkeypatch.chdir(folder)
    monkeypatch.setenv("PYTHONPATH", str(folder))
    monkeypatch.setenv("PATH", str(Path(sys.executable).parent), prepend=os.pathsep)
    written = write_files_of(page, folder)
    assert written
    printed = {}
    for language, code in FENCE.findall(text_of(page)):
        if language == "sh":
            for line in code.splitlines():
                result = subprocess.run(line, shell=True, capture_output=True, text=True)
                assert result.returncode == 0, f"{line}\n{result.stdout}{result.stderr}"
                printed[line] = result.stdout + result.stderr
        elif language == "python" and "import pandas" in code:
            result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
            assert result.returncode == 0, result.stderr
            printed["python"] = result.stdout
    return printed


@pytest.mark.slow
def test_map_tutorial_works(checkout: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    printed = run_tutorial("docs/tutorial-your-own-map.md", checkout, monkeypatch)
    [dry] = [text for command, text in printed.items() if "--dry-run" in command]
    assert re.search(r"^learn +12$", dry, re.MULTILINE), dry
    assert not re.search(r"^grow ", dry, re.MULTILINE), dry
    methods = yaml.safe_load(text_of("config/config.yaml"))["methods"]
    assert all(method in printed["python"] for method in methods)
    reports = checkout / "reports/smoke"
    for figure in ("map", "discovery"):
        assert (reports / f"figures/{figure}_courtyard.png").stat().st_size > 0
    for number, title in ((1, "Environment 1"), (6, "Environment 3"), (7, "Courtyard"), (8, "Courtyard")):
        assert title in (reports / f"tables/table{number}.html").read_text(encoding="utf-8")
    for figure in ("figure08", "figure12"):
        assert "courtyard" in (reports / f"figures/{figure}.csv").read_text(encoding="utf-8")


@pytest.mark.slow
def test_method_tutorial_works(checkout: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    printed = run_tutorial("docs/tutorial-your-own-method.md", checkout, monkeypatch)
    assert "random_skill" in printed["python"]
    reports = checkout / "reports/smoke"
    for number in range(1, 7):
        assert "Random skill" in (reports / f"tables/table{number}.html").read_text(encoding="utf-8")
    assert "random_skill" in (reports / "figures/figure12.csv").read_text(encoding="utf-8")
    per_seed = pd.read_csv(reports / "tables/per_seed.csv")
    assert (per_seed["method"] == "random_skill").sum() == 3 * 6 * 2


# -- citation


def test_citation_names_version_licence_and_article() -> None:
    citation = yaml.safe_load(text_of("CITATION.cff"))
    assert {"cff-version", "message", "title", "authors"} <= set(citation)
    assert citation["version"] == ptl.__version__
    assert citation["license"] == "MIT" and text_of("LICENSE").startswith("MIT License")
    assert "10.1177/1729881419831555" in citation["message"] and "probably" in citation["abstract"]
    assert f"## {ptl.__version__}\n" in text_of("CHANGELOG.md")


def test_catalogue_entry_is_readable() -> None:
    usage = yaml.safe_load(text_of(".snakemake-workflow-catalog.yml"))["usage"]
    assert {"mandatory-flags", "software-stack-deployment", "report"} <= set(usage)
