"""Compare the article's statements with the run's numbers."""

from ptl.files.atomic import write_text
from ptl.files.csv import read_csv
from ptl.report.differences import differences_table
from ptl.report.script import running
from ptl.report.table import to_html, to_markdown

with running(snakemake) as script:
    table = differences_table(
        read_csv(script.input.claims, keep_default_na=False),
        read_csv(script.input.parts, keep_default_na=False, na_values={"estimate": "", "low": "", "high": ""}),
        script.titles | {name: label for name, (label, _) in script.looks.items()},
    )
    write_text(script.output.md, to_markdown(table))
    write_text(script.output.html, to_html(table))
