"""Add up the subgoals of all batches of an environment."""

from ptl.files import store
from ptl.jobs.survey import merged
from ptl.report.script import running

with running(snakemake) as script:
    parts = list(script.results(script.input))
    store.write(script.output[0], parts[0].job.whole, merged(parts), parts[0].worlds)
