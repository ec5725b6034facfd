# The verdict on every claim of the article, from this run's own results.


rule judge_claims:
    input:
        per_seed=rules.measure.output.per_seed,
        subgoals=rules.measure.output.subgoals,
        steps=rules.measure.output.steps,
        growth=rules.collect_growth.output,
        selection_cost=rules.library_cost.output.selection,
        library_bytes=rules.library_cost.output.storage,
        maps=[entry["map"] for entry in entries().values()],
    output:
        csv="<reports>/claims.csv",
        parts="<reports>/claims_parts.csv",
        md="<reports>/claims.md",
        html=report(
            "<reports>/claims.html",
            caption="../report/claims.rst",
            category="1 Verdicts",
            labels={"item": "Claims: verdict and numbers for every claim"},
        ),
    log:
        "<logs>/claims.log",
    conda:
        "../envs/ptl.yaml"
    params:
        groups=groups("measures", "statistics", "growth"),
        environments=entries(),
        code=code_digest("ptl.study.claims", "ptl.study.evidence", "ptl.report.ledger"),
    message:
        "Judging the claims of the article"
    script:
        "../scripts/judge_claims.py"


rule explain_differences:
    input:
        claims=rules.judge_claims.output.csv,
        parts=rules.judge_claims.output.parts,
    output:
        md="<reports>/differences.md",
        html=report(
            "<reports>/differences.html",
            caption="../report/differences.rst",
            category="1 Verdicts",
            labels={
                "item": "Differences: the article's statements beside our numbers"
            },
        ),
    log:
        "<logs>/differences.log",
    conda:
        "../envs/ptl.yaml"
    params:
        code=code_digest("ptl.report.differences"),
    message:
        "Comparing the run with the article's statements"
    script:
        "../scripts/explain_differences.py"


rule claims:
    input:
        rules.judge_claims.output,
        rules.explain_differences.output,
