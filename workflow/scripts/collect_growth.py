"""Collect the size of the library after every task, from all lives of random tasks."""

from ptl.files.csv import write_csv
from ptl.report.job import running
from ptl.study.growth import library_sizes

with running(snakemake) as job:
    write_csv(library_sizes(job.input), job.output[0], sealed=True)
