"""Collect the size of the library after every task, from all lives of random tasks."""

from ptl.files.csv import write_csv
from ptl.measures.run_files import library_sizes
from ptl.report.script import running

with running(snakemake) as script:
    write_csv(library_sizes(script.results(script.input)), script.output[0])
