"""Build the explorer from the learning files of some seeds."""

from ptl.files.atomic import write_text
from ptl.report.explorer.data import collect
from ptl.report.explorer.page import build
from ptl.report.job import running

with running(snakemake) as job:
    write_text(job.output[0], build(collect(job.input, titles=job.titles, window=job.groups.measures.window)))
