"""Adding something takes the steps that docs/architecture.md names, and no others: done once, in one copy."""

from __future__ import annotations

from pathlib import Path

import pandas as pd
import pytest
from projects import TINY, Project

pytestmark = pytest.mark.slow

ADDED_FIGURE = '''
"""Steps of the first episode, seed by seed."""

import pandas as pd

from ptl.report.figures import style


def make(script):
    """Draw one dot for each seed."""
    frame = pd.read_csv(script.input.per_seed)[["seed", "first_episode"]]
    figure = style.new_figure(6, 4)
    figure.add_subplot().plot(frame["seed"], frame["first_episode"], "o")
    return figure, frame
'''

ADDED_METHOD = '''
"""Always explores anew."""

from ptl.methods.no_transfer import Method as NoTransfer


class Method(NoTransfer):
    """As `no_transfer`, with an exploration rate of its own."""

    label = "Wanderer"
    colour = "#123456"

    def run_episode(self, learner):
        learner.explore(epsilon=self.parameters.learning.wander)
        return []
'''

ADDED_CLAIM = '''

@claim("wander", "Wandering takes steps.", shown_in="table2")
def wander(evidence: Evidence) -> Iterator[Part]:
    """Count them."""
    steps = float(evidence.per_seed["total_steps"].min())
    yield above("steps", statistics.exactly(steps), 0.0, "steps")
'''


def put(path: Path, before: str, addition: str) -> None:
    """Insert text before a place that occurs once."""
    source = path.read_text(encoding="utf-8")
    assert source.count(before) == 1, (path, before)
    path.write_text(source.replace(before, addition + before), encoding="utf-8")


@pytest.fixture(scope="module")
def grown(tmp_path_factory: pytest.TempPathFactory) -> Project:
    """A copy with one addition of every kind, after a run."""
    project = Project(tmp_path_factory.mktemp("grown"))
    package = project.folder / "ptl"
    # an environment: a map and its entry
    (project.folder / "hall.txt").write_text("######\n#I...#\n#.#..#\n#..#A#\n######\n")
    environments = TINY["environments"] | {"hall": {"map": "hall.txt", "tasks": "A"}}
    # a hyper-parameter: a field (and its use, in the method)
    put(
        package / "config.py",
        '    max_steps: Annotated[\n        int, key("Steps after',
        '    wander: Annotated[float, key("Exploration rate of the wanderer.", CHOSEN, ge=0, le=1)] = 0.5\n',
    )
    # a method: a file
    (package / "methods/wanderer.py").write_text(ADDED_METHOD)
    project.configure(
        {**TINY, "environments": environments, "methods": [*TINY["methods"], "wanderer"],
         "learning": TINY["learning"] | {"wander": 0.75}}
    )  # fmt: skip
    # a measure: a definition
    put(
        package / "measures/measures.py",
        '    Measure("truncated",',
        '    Measure("longest", "Longest episode", "steps", "lower",\n'
        '            lambda curves: curves.steps.max(axis=1), "total", whole=True),\n',
    )
    # a table column: a Column
    put(
        package / "report/metric_tables.py",
        "\ndef build_tables(",
        'COLUMNS["total"] += (\n'
        '    MetricColumn("total_steps", "Total performance", "interquartile mean", "lower", value="iqm",\n'
        '                 low="iqm_low", high="iqm_high", spread=""),\n)\n\n',
    )
    # a figure: a module and a row
    (package / "report/figures/firsts.py").write_text(ADDED_FIGURE)
    put(
        package / "report/figures/__init__.py",
        '        "library_cost": Figure(',
        '        "firsts": Figure("firsts", "first episodes", "First episodes of all seeds.", needs=("per_seed",)),\n',
    )
    # a claim: a function
    source = package / "claims/library.py"
    source.write_text(source.read_text(encoding="utf-8") + ADDED_CLAIM, encoding="utf-8")
    project.make()
    return project


def table(project: Project, name: str) -> pd.DataFrame:
    return pd.read_csv(project.folder / "reports/tiny" / name)


def test_an_environment_and_a_method_are_in_every_table(grown: Project):
    per_seed = table(grown, "tables/per_seed.csv")
    assert set(per_seed["environment"]) == {"rooms", "hall"} and "wanderer" in set(per_seed["method"])
    page = (grown.folder / "reports/tiny/tables/table4.html").read_text()
    assert "Wanderer" in page and "hall" in page


def test_a_hyper_parameter_reaches_the_job_and_its_page(grown: Project):
    done = grown.ptl("inspect", "results/tiny/learning/hall/wanderer/seed_000.h5")
    assert "wander 0.75" in done.stdout
    grown.ptl("docs")
    assert "`learning.wander` | Exploration rate of the wanderer." in (grown.folder / "config/README.md").read_text()
    assert "number" in grown.snakemake("-n", "--config", "learning={wander: 2}").stderr


def test_a_measure_is_measured_estimated_and_shown(grown: Project):
    per_seed = table(grown, "tables/per_seed.csv")
    assert (per_seed["longest"] >= per_seed["first_episode"]).all()
    metrics = table(grown, "tables/metrics.csv").query("metric == 'longest' and environment == 'hall'")
    expected = per_seed[per_seed["environment"] == "hall"].groupby("method")["longest"].mean()
    assert metrics.set_index("method")["mean"].to_dict() == pytest.approx(expected.to_dict(), rel=1e-5)
    assert "Longest episode" in (grown.folder / "reports/tiny/tables/table2.md").read_text()


def test_a_table_column_is_in_every_format(grown: Project):
    folder = grown.folder / "reports/tiny/tables"
    for suffix in ("html", "md", "tex"):
        assert "interquartile mean" in (folder / f"table2.{suffix}").read_text()
    metrics = table(grown, "tables/metrics.csv").query("metric == 'total_steps' and environment == 'rooms'")
    assert table(grown, "tables/table2.csv")["total_steps_iqm"].tolist() == metrics["iqm"].tolist()


def test_a_figure_is_drawn(grown: Project):
    folder = grown.folder / "reports/tiny/figures"
    assert (folder / "firsts.png").read_bytes().startswith(b"\x89PNG") and (folder / "firsts.svg").is_file()
    assert len(table(grown, "figures/firsts.csv")) == len(table(grown, "tables/per_seed.csv"))


def test_a_claim_is_judged(grown: Project):
    assert table(grown, "claims.csv").set_index("id").loc["wander", "verdict"] == "reproduced"


def test_everything_new_is_in_the_manifest(grown: Project):
    manifest = (grown.folder / "reports/tiny/manifest.json").read_text()
    assert '"figures/firsts.png"' in manifest
    assert "Nothing to be done" in grown.make()
