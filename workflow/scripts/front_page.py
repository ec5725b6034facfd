"""Compose the first page of the report, and the page that leads to all products."""

from ptl.files.atomic import write_text
from ptl.files.csv import read_csv
from ptl.report.front_page import compose, compose_page
from ptl.report.script import running

with running(snakemake) as script:
    labels = {name: label for name, (label, _) in script.looks.items()}
    inputs = set(script.input.keys())
    claims = read_csv(script.input.claims, keep_default_na=False) if "claims" in inputs else None
    steps = read_csv(script.input.front).dropna(subset="ratio") if "front" in inputs else None
    seeds = int(read_csv(script.input.metrics)["seeds"].max())
    shown = (claims, steps, seeds, script.titles, labels, snakemake.params.run)
    given = snakemake.params
    write_text(script.output.text, compose(*shown))
    write_text(script.output.page, compose_page(*shown, given.figures, given.tables, given.front))
