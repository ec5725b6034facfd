"""Say how often the intervals of the tables contain the means of the many runs that decide the claims."""

from pathlib import Path

from ptl.claims.decision import evidence_of
from ptl.measures.coverage import coverage_table
from ptl.report import table
from ptl.report.coverage import coverage_page
from ptl.report.script import running

with running(snakemake) as script:
    runs, confidence = snakemake.params.seeds, script.groups.statistics.confidence
    evidence = evidence_of(script.results(script.input.decision), script.groups, confidence)
    coverage = coverage_table(evidence.per_seed, runs, confidence)
    page = coverage_page(coverage, runs, confidence, script.looks, script.titles)
    table.write(page, Path(script.output.csv), coverage, (".html", ".md", ".tex"))
