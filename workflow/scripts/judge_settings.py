"""Judge every claim on the raw files of a group of settings of the robustness study."""

import pandas as pd

from ptl.files.csv import write_csv
from ptl.report.job import running
from ptl.study.robustness.verdicts import load_setting, target_frame, verdict_frame

with running(snakemake) as job:
    verdicts, targets = [], []
    for path in job.input:
        setting = load_setting(path, job.groups)
        verdicts.append(verdict_frame(setting))
        targets.append(target_frame(setting))
    write_csv(pd.concat(verdicts), job.output.verdicts)
    write_csv(pd.concat([frame for frame in targets if len(frame)] or targets[:1]), job.output.targets)
