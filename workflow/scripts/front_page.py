"""Compose the first page of the report, and the page that leads to all products."""

from ptl.files.atomic import write_text
from ptl.files.csv import read_csv
from ptl.report.front_page import compose, compose_page
from ptl.report.job import running

with running(snakemake) as job:
    labels = {name: label for name, (label, _) in job.looks.items()}
    tasks = {name: entry.tasks for name, entry in job.environments.items()}
    claims = read_csv(job.input.claims, keep_default_na=False) if "claims" in job.input.keys() else None  # noqa: SIM118
    shown = (claims, read_csv(job.input.metrics), job.titles, tasks, labels)
    write_text(job.output.text, compose(*shown))
    write_text(job.output.page, compose_page(*shown, snakemake.params.figures, snakemake.params.tables))
