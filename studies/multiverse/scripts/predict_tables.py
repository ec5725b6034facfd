"""Predict every cell of the article's tables from the settings of the multiverse."""

from pathlib import Path

from ptl.files.csv import read_csv
from ptl.report.script import running
from studies.multiverse import prediction

with running(snakemake) as script:
    environments, methods = snakemake.params.order
    verdicts, estimates = (
        read_csv(script.input[name], dtype={"runs": str, "setting": str}) for name in ("verdicts", "estimates")
    )
    predictions = prediction.predict(estimates, verdicts, environments, methods)
    prediction.write_predictions(predictions, verdicts, Path(script.output.predictions).parent)
