"""Measure all learning files of a run: one row a seed, the subgoals, and the steps per episode."""

from ptl.files.csv import write_csv
from ptl.files.verification import OneRun
from ptl.report.job import running
from ptl.study.measures import measure_files, write_steps

with running(snakemake) as job:
    measures = job.groups.measures
    found = measure_files(job.input, measures.window, measures.threshold_factor, admit=OneRun().admit)
    write_csv(found.per_seed, job.output.per_seed, sealed=True)
    write_csv(found.subgoals, job.output.subgoals, sealed=True)
    write_steps(job.output.steps, found)
