# The figures: a row of ptl.report.figures.figures for each. One rule draws them all, as a PNG for reading, an SVG for
# printing and a CSV of the numbers drawn.

from ptl.files.schema import FREQUENCIES, GAIN, LEARNING
from ptl.report.figures import figures as figure_rows, item_label

FIGURES = figure_rows({**config, "methods": METHODS}, ARTICLE)


# Input files of a figure by kind, as its row asks for them.
SOURCES = {
    "maps": lambda row: [entry["map"] for entry in entries(row.environments).values()],
    "learning": lambda row: learning_files(row.environments, row.methods),
    "per_seed": lambda row: rules.measure.output.per_seed,
    "steps": lambda row: rules.measure.output.steps,
    "survey": lambda row: expand(
        "<results>/subgoal_frequencies/{environment}.h5", environment=row.environments
    ),
    "misleading_prior": lambda row: rules.misleading_prior_learning.input,
    "policy_reuse_experiment": lambda row: rules.fernandez_veloso_learning.input,
    "growth": lambda row: rules.collect_growth.output[0],
    "selection_cost": lambda row: rules.library_cost.output.selection,
    "library_bytes": lambda row: rules.library_cost.output.storage,
}

# Formats of those that answer a question.
KINDS = {
    "learning": LEARNING,
    "misleading_prior": LEARNING,
    "survey": FREQUENCIES,
    "policy_reuse_experiment": GAIN,
}


rule draw_figure:
    input:
        unpack(
            lambda wildcards: {
                kind: SOURCES[kind](FIGURES[wildcards.figure])
                for kind in FIGURES[wildcards.figure].needs
            }
        ),
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
        asked=lambda wildcards: asked(
            *[
                KINDS[kind]
                for kind in FIGURES[wildcards.figure].needs
                if kind in KINDS
            ],
            environments=FIGURES[wildcards.figure].environments,
            methods=FIGURES[wildcards.figure].methods,
        ),
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
            "ptl.report.figures.style",
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
