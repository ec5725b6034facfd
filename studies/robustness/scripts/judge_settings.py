"""Judge every claim on a group of settings of the robustness study."""

import pandas as pd

from ptl.files.csv import write_csv
from ptl.report.script import running
from studies.robustness.verdicts import evidence_of, target_frame, verdict_frame

with running(snakemake) as script:
    verdicts, targets = [], []
    for result in script.results(script.input.settings):
        setting = evidence_of(result, script.groups)
        verdicts.append(verdict_frame(setting))
        targets.append(target_frame(setting))
    write_csv(pd.concat(verdicts), script.output.verdicts)
    write_csv(pd.concat([frame for frame in targets if len(frame)] or targets[:1]), script.output.targets)
