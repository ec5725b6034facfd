"""Collect the files of lives: a row for each life of the main design, and for each task of every life."""

from ptl.files.csv import write_csv
from ptl.report.job import running
from ptl.study.population.collect import per_life, per_task

with running(snakemake) as job:
    tasks = per_task(job.input)
    write_csv(tasks, job.output.tasks, sealed=True)
    write_csv(per_life(tasks), job.output.lives, sealed=True)
