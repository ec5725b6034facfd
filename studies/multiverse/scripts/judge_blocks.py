"""Judge every claim in the settings of some blocks, under every reading, and keep the estimates behind it."""

import pandas as pd

from ptl.config import Configuration
from ptl.files.csv import write_csv
from ptl.report.script import running
from studies.multiverse.judging import ESTIMATE_COLUMNS, VERDICT_COLUMNS, estimate_rows, settings_in, verdict_rows

with running(snakemake) as script:
    run = Configuration.from_dict(snakemake.params.run)
    verdicts, estimates, states = [], [], []
    for result in script.results(script.input.blocks):
        for setting in settings_in(result, run):
            evidence = setting.evidence()
            verdicts += verdict_rows(setting.name, evidence)
            estimates += estimate_rows(setting.name, evidence)
            states.append((setting.name, setting.status))
    write_csv(pd.DataFrame(verdicts, columns=list(VERDICT_COLUMNS)), script.output.verdicts)
    write_csv(pd.DataFrame(estimates, columns=list(ESTIMATE_COLUMNS)), script.output.estimates)
    write_csv(pd.DataFrame(states, columns=["setting", "status"]), script.output.states)
