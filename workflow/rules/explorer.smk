# The page in which the learning of some seeds can be watched; complete in itself.

from ptl.explorer.page import source_digest

# A few seeds show how much runs differ. Chromium shows a page inside the report only up to 1.5 MB.
EXPLORER_SEEDS = list(SEEDS)[:3]


rule build_explorer:
    input:
        expand(
            "<results>/learning/{environment}/{method}/seed_{seed:03d}.h5",
            environment=ENVIRONMENTS,
            method=METHODS,
            seed=EXPLORER_SEEDS,
        ),
    output:
        report(
            "<reports>/explorer.html",
            caption="../report/explorer.rst",
            category="4 Explorer",
            labels={
                "item": "Explorer",
                "shows": "values, policies, skills and episodes, to play with",
            },
        ),
    log:
        "<logs>/explorer.log",
    conda:
        "../envs/ptl.yaml"
    params:
        titles=titles_option(),
        code=code_digest("ptl.commands.explorer"),
        labels=code_digest(*[f"ptl.methods.{method}" for method in METHODS]),
        page=source_digest(),
    message:
        "Building the explorer {output}"
    shell:
        "ptl explorer {input:q} --output {output:q} {params.titles} 2> {log:q}"


rule explorer:
    input:
        rules.build_explorer.output,
