"""Draw a figure: a PNG, its SVG twin and the plotted numbers as CSV."""

from importlib import import_module

from ptl.report.figures import saving
from ptl.report.script import running

with running(snakemake) as script:
    module = import_module(f"ptl.report.figures.{snakemake.params.module}")
    saving.save(*module.make(script), script.output.png)
