"""Judge every claim of the article, from the runs of the tables and from those that decide."""

from ptl.claims import judge
from ptl.claims.decision import evidence_of
from ptl.claims.evidence_files import read_evidence
from ptl.files.atomic import write_text
from ptl.files.csv import write_csv
from ptl.report import ledger
from ptl.report.script import running

FILES = ("per_seed", "steps", "subgoals", "growth", "selection_cost", "library_bytes")

with running(snakemake) as script:
    files = {name: str(getattr(script.input, name)) for name in FILES}
    evidence = read_evidence(script.worlds, script.groups, **files)
    few = judge(evidence)
    judgements, run = few, ledger.run_text(evidence.n_seeds(), evidence.n_seeds(), script.groups.statistics)
    if script.input.decision:
        costs = {name: getattr(evidence, name) for name in ("selection_cost", "library_bytes")}
        judgements = judge(evidence_of(script.results(script.input.decision), script.groups, **costs))
        decision = script.groups.decision
        others = {"no_transfer": decision.no_transfer_seeds, "full_transfer": decision.full_transfer_seeds}
        run = ledger.run_text(decision.seeds, evidence.n_seeds(), script.groups.statistics, others)
    write_csv(ledger.to_frame(judgements, few), script.output.csv)
    write_csv(ledger.to_parts_frame(judgements, few), script.output.parts)
    write_text(script.output.md, ledger.to_markdown(judgements, few, run))
    write_text(script.output.html, ledger.to_html(judgements, few, run))
