"""Compose the first page of the report."""

from ptl.files.atomic import write_text
from ptl.files.csv import read_csv
from ptl.report.front_page import compose
from ptl.report.job import running

with running(snakemake) as job:
    labels = {name: label for name, (label, _) in job.looks.items()}
    tasks = {name: entry.tasks for name, entry in job.environments.items()}
    claims = read_csv(job.input.claims, keep_default_na=False)
    write_text(job.output[0], compose(claims, read_csv(job.input.metrics), job.titles, tasks, labels))
