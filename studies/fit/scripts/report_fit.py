"""Describe the search for drawings and settings that fit."""

from pathlib import Path

from ptl.files.atomic import write_text
from ptl.files.csv import read_csv
from ptl.report.script import running
from ptl.report.table import to_html, to_markdown
from studies.fit.page import FINAL, SCREEN, claims_table, halves_table, settings_table
from studies.fit.search import read_search

with running(snakemake) as script:
    tried = read_csv(script.input.tried)
    tables = {
        "decided": settings_table(tried, FINAL),
        "halves": halves_table(read_csv(script.input.halves)),
        "claims": claims_table(tried, read_search(script.input.search).halves),
        "screened": settings_table(tried, SCREEN),
    }
    folder = Path(script.output.page).parent
    write_text(script.output.page, "\n".join(map(to_markdown, tables.values())))
    for name, table in tables.items():
        write_text(folder / f"{name}.html", to_html(table))
