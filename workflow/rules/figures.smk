# The figures: a row of ptl.report.figures.figures for each. One rule draws them all, as a PNG for reading, an SVG for
# printing and a CSV of the numbers drawn.

from ptl.report.figures import figures as figure_rows, heading, item_label, on_page

FIGURES = figure_rows({**config, "methods": METHODS}, ARTICLE)


rule draw_figure:
    input:
        unpack(lambda wildcards: sources_of(FIGURES[wildcards.figure])),
    output:
        png=report(
            "<reports>/figures/{figure}.png",
            caption="../report/figure.rst",
            category=lambda wildcards: section(FIGURES[wildcards.figure].category),
            labels=lambda wildcards: {
                "item": item_label(wildcards.figure, FIGURES[wildcards.figure]),
                "shows": FIGURES[wildcards.figure].shows,
            },
        ),
        twins=multiext("<reports>/figures/{figure}", ".svg", ".csv"),
    log:
        "<logs>/figures/{figure}.log",
    wildcard_constraints:
        figure="|".join(FIGURES),
    conda:
        "../envs/ptl.yaml"
    params:
        module=lambda wildcards: FIGURES[wildcards.figure].module,
        caption=lambda wildcards: FIGURES[wildcards.figure].caption,
        groups=lambda wildcards: groups(*FIGURES[wildcards.figure].groups),
        jobs=lambda wildcards: packed(result_jobs(FIGURES[wildcards.figure])),
        maps=lambda wildcards: map_digests(FIGURES[wildcards.figure].environments),
        environments=lambda wildcards: entries(FIGURES[wildcards.figure].environments),
        methods=lambda wildcards: FIGURES[wildcards.figure].methods,
        looks=lambda wildcards: looks(
            [name for name in FIGURES[wildcards.figure].methods if name in METHODS]
        ),
        foreign=lambda wildcards: (
            FOREIGN if FIGURES[wildcards.figure].with_foreign else {}
        ),
        code=lambda wildcards: code_digest(
            "ptl.report.figures.saving",
            f"ptl.report.figures.{FIGURES[wildcards.figure].module}",
            *method_modules(FIGURES[wildcards.figure].methods),
        ),
    message:
        "Drawing {wildcards.figure}"
    script:
        "../scripts/draw_figure.py"


rule figures:
    input:
        expand(
            "<reports>/figures/{figure}.{format}",
            format=["png", "svg", "csv"],
            figure=FIGURES,
        ),
