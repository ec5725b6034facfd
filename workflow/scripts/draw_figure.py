"""Draw a figure: a PNG, its SVG twin and the plotted numbers as CSV."""

from importlib import import_module

from ptl.report.figures import style
from ptl.report.job import running

with running(snakemake) as job:
    module = import_module(f"ptl.report.figures.{snakemake.params.module}")
    style.save(*module.make(job), job.output.png)
