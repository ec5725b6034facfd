# Estimates with their intervals, and the article's tables.

from ptl.report.table_kinds import table_labels

TABLE_FORMATS = ["html", "md", "tex", "csv"]
TABLES = table_labels(config["environments"])


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
                category=section("Tables"),
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
        groups=groups("measures", "statistics"),
        environments=entries(),
        looks=looks(),
        foreign=FOREIGN,
        code=code_digest("ptl.report.metric_tables"),
    message:
        "Estimating every measure and laying out {output.metrics} and the tables"
    script:
        "../scripts/tabulate.py"


rule tables:
    input:
        rules.measure.output.per_seed,
        rules.measure.output.subgoals,
        rules.measure.output.episodes,
        rules.tabulate.output,
        rules.collect_growth.output if GROWTH else [],
        rules.library_cost.output,
