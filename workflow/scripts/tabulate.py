"""Estimate every measure with its interval and lay out the article's tables."""

from pathlib import Path

from ptl.config import of_article
from ptl.files.csv import write_csv
from ptl.measures.run_files import read_per_seed
from ptl.measures.statistics import Resampling, summarise
from ptl.report.metric_tables import build_tables, write_tables
from ptl.report.script import running

with running(snakemake) as script:
    statistics = script.groups.statistics
    metrics = summarise(
        read_per_seed(script.input.per_seed),
        Resampling(statistics.confidence, statistics.resamples),
    )
    write_csv(metrics, script.output.metrics)
    write_tables(
        build_tables(
            metrics, script.groups.measures, statistics, script.looks, script.titles, of_article(script.environments)
        ),
        Path(script.output.metrics).parent,
    )
