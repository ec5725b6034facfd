"""Measure all learning files of a run: one row a seed, the subgoals, and the steps per episode."""

import numpy as np

from ptl.errors import UserError
from ptl.files.configuration import expected_of
from ptl.files.csv import write_csv
from ptl.files.foreign import read_foreign
from ptl.files.regular import sha256
from ptl.measures.measures import Runs
from ptl.measures.run_files import episode_table, measure_files, write_steps
from ptl.report.script import running

with running(snakemake) as script:
    measures = script.groups.measures
    expected = expected_of(script.environments, snakemake.params.seeds, script.groups.learning)
    foreign = [
        Runs(environment, method, task, np.arange(expected.seeds), runs.steps, runs.truncated)
        for method, entry in script.foreign.items()
        for (environment, task), runs in read_foreign(entry.file, method, expected).items()
    ]
    for method, entry in script.foreign.items():
        if sha256(entry.file) != snakemake.params.foreign_digests[method]:
            raise UserError(f"{entry.file}: was changed during the run; run the same command again")
    results = script.results(script.input.learning)
    measured = measure_files(results, measures.window, measures.threshold_factor, foreign, script.groups.learning)
    write_csv(measured.per_seed, script.output.per_seed)
    write_csv(measured.subgoals, script.output.subgoals)
    write_csv(episode_table(measured), script.output.episodes)
    write_steps(script.output.steps, measured.steps)
