"""Judge every claim of the article, from the runs of the tables and from those that decide."""

from ptl.claims import CLAIMS, judge
from ptl.claims.decision import confidence_at, evidence_of
from ptl.claims.degrees import degrees_of
from ptl.claims.evidence_files import read_evidence
from ptl.files.atomic import write_text
from ptl.files.csv import write_csv
from ptl.report import ledger
from ptl.report.script import running

FILES = ("per_seed", "steps", "subgoals", "growth", "selection_cost", "library_bytes")

with running(snakemake) as script:
    files = {name: str(getattr(script.input, name)) for name in FILES}
    evidence = read_evidence(script.worlds, script.groups, survey=script.results(script.input.survey), **files)
    few = judge(evidence)
    deciding, run = evidence, ledger.run_text(evidence.n_seeds(), script.groups.statistics)
    if script.input.decision:
        shared = {name: getattr(evidence, name) for name in ("frequencies", "selection_cost", "library_bytes")}
        results = list(script.results(script.input.decision))
        looks = script.groups.decision.looks
        last = max(result.job.look for result in results)
        level = confidence_at(last, looks, script.groups.statistics.confidence)
        deciding = evidence_of(results, script.groups, level, **shared)
        run = ledger.decided_text(results, looks, level, evidence.n_seeds(), script.groups.statistics)
    entries = [*map(ledger.Entry, judge(deciding), few, degrees_of(CLAIMS, deciding))]
    names = script.titles | {name: label for name, (label, _) in script.looks.items()}
    write_csv(ledger.to_frame(entries), script.output.csv)
    write_csv(ledger.to_parts_frame(entries), script.output.parts)
    write_text(script.output.md, ledger.to_markdown(entries, run, names))
    write_text(script.output.html, ledger.to_html(entries, run, names))
