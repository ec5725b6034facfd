"""Judge every claim of the article, from the runs of the tables and from those that decide."""

from ptl.files.atomic import write_text
from ptl.files.csv import write_csv
from ptl.report import ledger
from ptl.report.job import running
from ptl.study.claims import judge
from ptl.study.decision import read_decision
from ptl.study.evidence import read_evidence

FILES = ("per_seed", "steps", "subgoals", "growth", "selection_cost", "library_bytes")

with running(snakemake) as job:
    files = {name: str(getattr(job.input, name)) for name in FILES}
    evidence = read_evidence(job.worlds, job.groups, **files)
    few = judge(evidence)
    judgements, run = few, ledger.run_text(evidence.n_seeds(), evidence.n_seeds(), job.groups.statistics)
    if job.input.decision:
        costs = {name: getattr(evidence, name) for name in ("selection_cost", "library_bytes")}
        judgements = judge(read_decision(job.input.decision, job.groups, **costs))
        decision = job.groups.decision
        others = {"no_transfer": decision.no_transfer_seeds, "full_transfer": decision.full_transfer_seeds}
        run = ledger.run_text(decision.seeds, evidence.n_seeds(), job.groups.statistics, others)
    write_csv(ledger.to_frame(judgements, few), job.output.csv, sealed=True)
    write_csv(ledger.to_parts_frame(judgements, few), job.output.parts, sealed=True)
    write_text(job.output.md, ledger.to_markdown(judgements, few, run))
    write_text(job.output.html, ledger.to_html(judgements, few, run))
