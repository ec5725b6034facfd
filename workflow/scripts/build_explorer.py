"""Build the explorer from the learning files of some seeds."""

from ptl.files.atomic import write_text
from ptl.files.outside import configured
from ptl.report.explorer.data import collect
from ptl.report.explorer.page import build
from ptl.report.job import running

with running(snakemake) as job:
    kinds = {name: configured(*given) for name, given in snakemake.params.given.items()}
    data = collect(job.input, titles=job.titles, window=job.groups.measures.window, kinds=kinds)
    write_text(job.output[0], build(data))
