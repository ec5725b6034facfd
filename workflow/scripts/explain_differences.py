"""Set the article's statements beside the run's numbers."""

from ptl.files.atomic import write_text
from ptl.files.csv import read_csv
from ptl.report.differences import differences_table
from ptl.report.job import running
from ptl.report.table import to_html, to_markdown

with running(snakemake) as job:
    shares = snakemake.params.shares
    table = differences_table(
        read_csv(job.input.claims, keep_default_na=False),
        read_csv(job.input.parts, keep_default_na=False, na_values={"estimate": "", "low": "", "high": ""}),
        read_csv(shares["path"]) if shares else None,
    )
    write_text(job.output.md, to_markdown(table))
    write_text(job.output.html, to_html(table))
