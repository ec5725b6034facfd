"""Tabulate the gain of policy reuse in the experiment of its authors."""

from pathlib import Path

from ptl.report.job import running
from ptl.report.policy_reuse_experiment import gain_frame, gain_table
from ptl.report.table import write
from ptl.study.policy_reuse_experiment import read_gains
from ptl.study.statistics import Resampling

with running(snakemake) as job:
    statistics = job.groups.statistics
    frame = gain_frame(read_gains(job.input), Resampling(statistics.confidence, statistics.resamples))
    write(gain_table(frame, statistics.confidence), Path(job.output.page), frame)
