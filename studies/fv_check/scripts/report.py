"""The gain of policy reuse in the experiment of its authors, as a table and as a figure."""

from pathlib import Path

from ptl.measures.statistics import Resampling
from ptl.report.figures import saving
from ptl.report.script import running
from ptl.report.table import write
from studies.fv_check import figure, page
from studies.fv_check.jobs import gains_of

with running(snakemake) as script:
    statistics = script.groups.statistics
    gains = gains_of(script.results(script.input))
    frame = page.gain_frame(gains, Resampling(statistics.confidence, statistics.resamples))
    table = page.gain_table(frame, statistics.confidence, script.jobs[0].library_trials)
    write(table, Path(script.output.page), frame)
    curves = figure.gain_frame(gains, statistics)
    saving.save(figure.draw(curves), curves, script.output.png)
