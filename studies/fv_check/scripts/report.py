"""The gain of policy reuse in the experiment of its authors under each reading, as a table and as a figure."""

from pathlib import Path

from ptl.measures.statistics import Resampling
from ptl.report.figures import saving
from ptl.report.script import running
from ptl.report.table import write
from studies.fv_check import figure, page
from studies.fv_check.jobs import gains_of, readings_of

with running(snakemake) as script:
    statistics = script.groups.statistics
    results = list(script.results(script.input))
    gains = gains_of(results)
    frame = page.gain_frame(gains, readings_of(results), Resampling(statistics.confidence, statistics.resamples))
    job = gains[0].job
    table = page.gain_table(frame, job.trials, job.library_trials, statistics.confidence)
    write(table, Path(script.output.page), frame)
    saving.save(figure.draw(frame, statistics.confidence), frame, script.output.png)
