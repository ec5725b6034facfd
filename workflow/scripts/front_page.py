"""Compose the first page of the report, and the page that leads to all products."""

from ptl.files.atomic import write_text
from ptl.files.csv import read_csv
from ptl.report.front_page import compose, compose_page
from ptl.report.script import running

with running(snakemake) as script:
    labels = {name: label for name, (label, _) in script.looks.items()}
    tasks = {name: entry.tasks for name, entry in script.environments.items()}
    claims = read_csv(script.input.claims, keep_default_na=False) if "claims" in script.input.keys() else None  # noqa: SIM118
    shown = (claims, read_csv(script.input.metrics), script.titles, tasks, labels)
    write_text(script.output.text, compose(*shown))
    write_text(script.output.page, compose_page(*shown, snakemake.params.figures, snakemake.params.tables))
