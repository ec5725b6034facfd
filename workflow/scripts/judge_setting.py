"""Judge every claim on the raw file of one setting of the robustness study."""

from ptl.files.csv import write_csv
from ptl.report.job import running
from ptl.study.robustness.verdicts import load_setting, target_frame, verdict_frame

with running(snakemake) as job:
    setting = load_setting(job.input[0], job.groups)
    write_csv(verdict_frame(setting), job.output.verdicts)
    write_csv(target_frame(setting), job.output.targets)
