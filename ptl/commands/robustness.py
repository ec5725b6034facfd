"""``ptl robustness``: one setting of the robustness study, its verdicts, and the products of all settings."""

from __future__ import annotations

import json
from pathlib import Path

import click

FILE = click.Path(dir_okay=False, path_type=Path)


@click.group()
def command() -> None:
    """Vary what the article leaves open, and see which verdicts hang on it."""


@command.command("learn")
@click.option("--job", required=True, help="The setting with all that it needs, as JSON (see `ptl robustness jobs`).")
@click.option("--output", required=True, type=FILE, help="HDF5 file to write.")
def learn(job: str, output: Path) -> None:
    """Learn one setting: all environments, methods and seeds, and the growth of the library."""
    from ptl.robustness.running import run_setting

    run_setting(json.loads(job), output)


@command.command("jobs")
@click.argument("study", type=FILE)
@click.option("--config", "config_path", required=True, type=FILE, help="Configuration of the run, with all its keys.")
def jobs(study: Path, config_path: Path) -> None:
    """Print the job of every setting of STUDY (config/robustness.yaml), one line of JSON each."""
    import yaml

    from ptl.robustness.design import job_of, read_study

    config = yaml.safe_load(config_path.read_text(encoding="utf-8"))
    plan = read_study(study)
    for setting in plan.settings():
        click.echo(json.dumps(job_of(setting, plan, config), sort_keys=True))


@command.command("judge")
@click.argument("file", type=FILE)
@click.option("--window", required=True, type=click.IntRange(min=1), help="As given to `ptl measure`.")
@click.option("--threshold-factor", required=True, type=click.FloatRange(min=1), help="As given to `ptl measure`.")
@click.option("--confidence", required=True, type=click.FloatRange(0, 1, True, True), help="Level of intervals.")
@click.option("--resamples", required=True, type=click.IntRange(min=1), help="Bootstrap resamples.")
@click.option("--output-verdicts", required=True, type=FILE, help="CSV of the verdict on every claim.")
@click.option("--output-targets", required=True, type=FILE, help="CSV of the numbers behind claims under suspicion.")
def judge(
    file: Path,
    window: int,
    threshold_factor: float,
    confidence: float,
    resamples: int,
    output_verdicts: Path,
    output_targets: Path,
) -> None:
    """Judge every claim on the raw FILE of one setting."""
    from ptl.files import write_csv
    from ptl.robustness.verdicts import load_setting, target_frame, verdict_frame
    from ptl.statistics import Resampling

    setting = load_setting(file, window, threshold_factor, Resampling(confidence, resamples))
    write_csv(verdict_frame(setting), output_verdicts)
    write_csv(target_frame(setting), output_targets)


@command.command("report")
@click.argument("folder", type=click.Path(file_okay=False, path_type=Path))
@click.option("--study", required=True, type=FILE, help="config/robustness.yaml.")
@click.option("--output-folder", required=True, type=click.Path(file_okay=False, path_type=Path),
              help="Folder for the tables and the heat map.")  # fmt: skip
def report(folder: Path, study: Path, output_folder: Path) -> None:
    """Put the verdicts of all settings in FOLDER together: shares, ranks, targeted numbers, heat map."""
    from ptl.figures import robustness as figure
    from ptl.figures import style
    from ptl.files import write_csv, write_text
    from ptl.robustness import pages, summary
    from ptl.robustness.design import read_study

    plan = read_study(study)
    names = [setting.name for setting in plan.settings()]
    verdicts = summary.read_verdicts(folder / f"{name}.verdicts.csv" for name in names)
    targets = summary.read_tables(folder / f"{name}.targets.csv" for name in names)
    settings = summary.setting_table(verdicts, plan.unknowns)
    shares = summary.share_table(verdicts, plan.unknowns)
    ranks = summary.unknown_table(verdicts, plan.unknowns)
    # what a setting changes stands in settings.csv, the numbers behind a verdict in the folder of results
    write_csv(verdicts.drop(columns=["changes", "evidence"]), output_folder / "verdicts.csv")
    write_csv(settings, output_folder / "settings.csv")
    write_csv(targets, output_folder / "targeted.csv")
    for name, table, page in (
        ("share", shares, pages.share_page(shares, settings)),
        ("unknowns", ranks, pages.unknown_page(ranks)),
    ):
        write_csv(table, output_folder / f"{name}.csv")
        write_text(output_folder / f"{name}.md", page.to_markdown())
        write_text(output_folder / f"{name}.html", page.to_html())
    found = list(pages.target_pages(targets, verdicts, plan.unknowns))
    write_text(output_folder / "targeted.md", "\n".join(page.to_markdown() for page in found))
    frame = figure.heat_frame(verdicts)
    style.save(figure.draw(frame, plan.unknowns), frame, output_folder / "heat_map.png")
    unfinished = settings[settings["status"] != "complete"]
    for row in unfinished.itertuples():
        click.echo(f"warning: setting {row.setting} did not finish: {row.status}", err=True)
