"""Tabulate the gain of policy reuse in the experiment of its authors."""

from pathlib import Path

from ptl.measures.statistics import Resampling
from ptl.report.script import running
from ptl.report.table import write
from studies.fv_check.experiment import read_gains
from studies.fv_check.page import gain_frame, gain_table

with running(snakemake) as script:
    statistics = script.groups.statistics
    frame = gain_frame(read_gains(script.input), Resampling(statistics.confidence, statistics.resamples))
    write(gain_table(frame, statistics.confidence), Path(script.output.page), frame)
