"""Measure all learning files of a run: one row a seed, the subgoals, and the steps per episode."""

import numpy as np

from ptl.files.configuration import expected_of
from ptl.files.csv import write_csv
from ptl.files.foreign import read_foreign
from ptl.files.verification import OneRun
from ptl.report.job import running
from ptl.study.measures import Runs, measure_files, write_steps

with running(snakemake) as job:
    measures = job.groups.measures
    expected = expected_of(job.environments, snakemake.params.seeds, job.groups.learning)
    foreign = [
        Runs(environment, method, task, np.arange(expected.seeds), runs.steps, runs.truncated)
        for method, entry in job.foreign.items()
        for (environment, task), runs in read_foreign(entry.file, method, expected).items()
    ]
    found = measure_files(
        job.input.learning, measures.window, measures.threshold_factor, admit=OneRun().admit, foreign=foreign
    )
    write_csv(found.per_seed, job.output.per_seed, sealed=True)
    write_csv(found.subgoals, job.output.subgoals, sealed=True)
    write_steps(job.output.steps, found)
