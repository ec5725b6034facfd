# The verdict on every claim of the article, from this run's own results.


rule judge_claims:
    input:
        per_seed=rules.measure.output.per_seed,
        subgoals=rules.measure.output.subgoals,
        steps=rules.measure.output.steps,
        growth="<reports>/tables/growth.csv",
        selection_cost="<reports>/tables/selection_cost.csv",
        library_bytes="<reports>/tables/library_bytes.csv",
        maps=[
            config["environments"][environment]["map"] for environment in ENVIRONMENTS
        ],
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
        maps=map_options(),
        confidence=config["statistics"]["confidence"],
        resamples=config["statistics"]["resamples"],
        code=code_digest("ptl.commands.claims", "ptl.claims", "ptl.evidence"),
    message:
        "Judging the claims of the article"
    shell:
        "ptl claims {input.per_seed:q} {params.maps} --subgoals {input.subgoals:q} --steps {input.steps:q}"
        " --growth {input.growth:q} --selection-cost {input.selection_cost:q}"
        " --library-bytes {input.library_bytes:q} --confidence {params.confidence}"
        " --resamples {params.resamples} --output-csv {output.csv:q} --output-parts {output.parts:q}"
        " --output-md {output.md:q} --output-html {output.html:q} 2> {log:q}"


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
                "item": "Differences: the article's numbers beside ours, and why they differ"
            },
        ),
    log:
        "<logs>/differences.log",
    conda:
        "../envs/ptl.yaml"
    params:
        code=code_digest("ptl.commands.differences", "ptl.differences"),
    message:
        "Laying out where the run differs from the article"
    shell:
        "ptl differences {input.claims:q} {input.parts:q} --output-md {output.md:q} --output-html {output.html:q}"
        " 2> {log:q}"


rule claims:
    input:
        rules.judge_claims.output,
        rules.explain_differences.output,
