"""Collect the files of lives: a row for each life of the main design, and for each task of every life."""

from ptl.files.csv import write_csv
from ptl.report.script import running
from studies.beyond.collect import per_life, per_task

with running(snakemake) as script:
    tasks = per_task(script.results(script.input))
    write_csv(tasks, script.output.tasks)
    write_csv(per_life(tasks), script.output.lives)
