"""Summarise the verdicts of all settings: shares, ranks, targeted numbers and the heat map."""

import sys
from pathlib import Path

from ptl.files.atomic import write_text
from ptl.files.csv import write_csv
from ptl.report.figures import saving
from ptl.report.script import running
from ptl.report.table import to_markdown, write
from studies.robustness import figure, pages, summary
from studies.robustness.design import read_study

with running(snakemake) as script:
    unknowns = read_study(script.input.study).unknowns
    folder = Path(script.output.png).parent
    verdicts = summary.read_verdicts(script.input.verdicts)
    targets = summary.read_tables(script.input.targets)
    settings = summary.setting_table(verdicts, unknowns)
    shares = summary.share_table(verdicts, unknowns)
    ranks = summary.unknown_table(verdicts, unknowns)
    # changes are in settings.csv
    write_csv(verdicts.drop(columns=["changes", "evidence"]), folder / "verdicts.csv")
    write_csv(settings, folder / "settings.csv")
    write_csv(targets, folder / "targeted.csv")
    write(pages.share_table(shares, settings), folder / "share", shares)
    write(pages.unknown_table(ranks), folder / "unknowns", ranks)
    targeted = pages.target_tables(targets, verdicts, unknowns)
    write_text(folder / "targeted.md", "\n".join(map(to_markdown, targeted)))
    frame = figure.heat_frame(verdicts)
    saving.save(figure.draw(frame, unknowns), frame, folder / "heat_map.png")
    for row in settings[settings["status"] != "complete"].itertuples():
        print(f"warning: setting {row.setting} did not finish: {row.status}", file=sys.stderr)
