"""Judge every claim of the article from the results of the run."""

from ptl.files.atomic import write_text
from ptl.files.csv import write_csv
from ptl.report import ledger
from ptl.report.job import running
from ptl.study.claims import judge
from ptl.study.evidence import read_evidence

FILES = ("per_seed", "steps", "subgoals", "growth", "selection_cost", "library_bytes")

with running(snakemake) as job:
    files = {name: str(getattr(job.input, name)) for name in FILES}
    evidence = read_evidence(job.worlds, job.groups, **files)
    judgements = judge(evidence)
    seeds, statistics = evidence.n_seeds(), job.groups.statistics
    write_csv(ledger.to_frame(judgements), job.output.csv, sealed=True)
    write_csv(ledger.to_parts_frame(judgements), job.output.parts, sealed=True)
    write_text(job.output.md, ledger.to_markdown(judgements, seeds, statistics))
    write_text(job.output.html, ledger.to_html(judgements, seeds, statistics))
