"""Estimate every measure with its interval and lay out the article's tables."""

from pathlib import Path

from ptl.config import of_article
from ptl.files.csv import write_csv
from ptl.report.job import running
from ptl.report.metric_tables import build_tables, write_tables
from ptl.study.statistics import Resampling, read_per_seed, summarise

with running(snakemake) as job:
    statistics = job.groups.statistics
    metrics = summarise(
        read_per_seed(job.input.per_seed),
        Resampling(statistics.confidence, statistics.resamples),
    )
    write_csv(metrics, job.output.metrics, sealed=True)
    write_tables(
        build_tables(metrics, job.groups.measures, statistics, job.looks, job.titles, of_article(job.environments)),
        Path(job.output.metrics).parent,
    )
