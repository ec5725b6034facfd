# Estimates with their intervals, and the article's tables.

TABLE_FORMATS = ["html", "md", "tex", "csv"]
MEASURES_SHARED_OUT = [
    "jump start, asymptotic performance, time to threshold",
    "total performance, transfer ratio",
]
TABLES = {
    f"table{number}": f"Table {number}: {title_of(environment)}, {measures}"
    for number, (environment, measures) in enumerate(
        itertools.product(ENVIRONMENTS, MEASURES_SHARED_OUT), start=1
    )
}


rule tabulate:
    input:
        per_seed=rules.measure.output.per_seed,
    output:
        metrics="<reports>/tables/metrics.csv",
        tables=expand(
            "<reports>/tables/{table}.{format}",
            table=TABLES,
            format=TABLE_FORMATS[1:],
        ),
        pages=[
            report(
                f"<reports>/tables/{table}.html",
                caption="../report/table.rst",
                category="3 Tables",
                labels={"item": label},
            )
            for table, label in TABLES.items()
        ],
    log:
        "<logs>/tabulate.log",
    priority: 1
    conda:
        "../envs/ptl.yaml"
    params:
        folder=lambda wildcards, output: os.path.dirname(output.metrics),
        environments=titles_option(),
        window=config["measures"]["window"],
        threshold_factor=config["measures"]["threshold_factor"],
        confidence=config["statistics"]["confidence"],
        resamples=config["statistics"]["resamples"],
        code=code_digest("ptl.commands.tables", "ptl.statistics", "ptl.tables"),
        labels=code_digest(*[f"ptl.methods.{method}" for method in METHODS]),
    message:
        "Estimating every measure and laying out {output.metrics} and the tables"
    shell:
        "ptl tables {input.per_seed:q} --output-metrics {output.metrics:q} --output-folder {params.folder:q}"
        " {params.environments} --window {params.window}"
        " --threshold-factor {params.threshold_factor} --confidence {params.confidence}"
        " --resamples {params.resamples} 2> {log:q}"


rule tables:
    input:
        rules.measure.output.per_seed,
        rules.measure.output.subgoals,
        rules.tabulate.output,
        rules.collect_growth.output,
        rules.library_cost.output,
