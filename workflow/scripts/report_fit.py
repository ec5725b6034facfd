"""Describe the search for drawings and settings that fit."""

from pathlib import Path

from ptl.files.atomic import write_text
from ptl.files.csv import read_csv
from ptl.report.fit import FINAL, SCREEN, claims_table, halves_table, settings_table
from ptl.report.job import running
from ptl.report.table import to_html, to_markdown
from ptl.study.fit import read_search

with running(snakemake) as job:
    tried = read_csv(job.input.tried)
    tables = {
        "decided": settings_table(tried, FINAL),
        "halves": halves_table(read_csv(job.input.halves)),
        "claims": claims_table(tried, read_search(job.input.search).halves),
        "screened": settings_table(tried, SCREEN),
    }
    folder = Path(job.output.page).parent
    write_text(job.output.page, "\n".join(map(to_markdown, tables.values())))
    for name, table in tables.items():
        write_text(folder / f"{name}.html", to_html(table))
