# The verdict on every claim of the article: from the runs of the tables, and from many more that decide it.


rule decide:
    input:
        maps=lambda wildcards: map_files(DECISION[f"decision/{wildcards.job}.h5"].maps),
    output:
        "<results>/decision/{job}.h5",
    log:
        "<logs>/decision/{job}.log",
    wildcard_constraints:
        job="[a-z0-9_]+",
    # Among the longest jobs of the run; short ones then fill the second core.
    priority: 2
    conda:
        "../envs/ptl.yaml"
    params:
        job=job_of,
        maps=maps_of,
    message:
        "Learning {wildcards.job} with the seeds that decide the claims"
    shell:
        "ptl run --job {params.job:q} {params.maps:q} --output {output:q} 2> {log:q}"


checkpoint look:
    input:
        lambda wildcards: decided(int(wildcards.look)),
    output:
        open="<results>/decision/look_{look}.json",
    log:
        "<logs>/decision/look_{look}.log",
    wildcard_constraints:
        look="[0-9]+",
    priority: 3
    conda:
        "../envs/ptl.yaml"
    params:
        groups=groups("learning", "measures", "statistics", "growth", "decision"),
        jobs=packed(DECISION.values()),
        code=code_digest("ptl.claims.decision", "ptl.claims"),
    message:
        "Judging the claims at look {wildcards.look}"
    script:
        "../scripts/look.py"


rule judge_claims:
    input:
        per_seed=rules.measure.output.per_seed,
        subgoals=rules.measure.output.subgoals,
        steps=rules.measure.output.steps,
        growth=rules.collect_growth.output,
        survey=files_of(SURVEYS),
        selection_cost=rules.library_cost.output.selection,
        library_bytes=rules.library_cost.output.storage,
        decision=lambda wildcards: decided(LAST_LOOK),
        maps=map_files(),
    output:
        csv="<reports>/claims.csv",
        parts="<reports>/claims_parts.csv",
        md="<reports>/claims.md",
        html=report(
            "<reports>/claims.html",
            caption="../report/claims.rst",
            category=section("Verdicts"),
            labels={"item": "Claims: verdict and numbers for every claim"},
        ),
    log:
        "<logs>/claims.log",
    conda:
        "../envs/ptl.yaml"
    params:
        groups=groups("learning", "measures", "statistics", "growth", "decision"),
        jobs=packed([*SURVEYS.values(), *DECISION.values()]),
        maps=map_digests(),
        environments=entries(),
        looks=looks(),
        code=code_digest(
            "ptl.claims.decision", "ptl.claims.evidence_files", "ptl.report.ledger"
        ),
    message:
        "Judging the claims of the article"
    script:
        "../scripts/judge_claims.py"


rule cover:
    input:
        decision=lambda wildcards: decided(LAST_LOOK),
    output:
        csv="<reports>/tables/coverage.csv",
        md="<reports>/tables/coverage.md",
        tex="<reports>/tables/coverage.tex",
        html=report(
            "<reports>/tables/coverage.html",
            caption="../report/coverage.rst",
            category=section("Verdicts"),
            labels={"item": "Coverage of the intervals of the tables"},
        ),
    log:
        "<logs>/cover.log",
    conda:
        "../envs/ptl.yaml"
    params:
        groups=groups("learning", "measures", "statistics", "growth"),
        jobs=packed(DECISION.values()),
        environments=entries(),
        looks=looks(),
        seeds=config["seeds"],
        code=code_digest("ptl.claims.decision", "ptl.report.coverage"),
    message:
        "Checking the level of the tables' intervals"
    script:
        "../scripts/cover.py"


rule explain_differences:
    input:
        claims=rules.judge_claims.output.csv,
        parts=rules.judge_claims.output.parts,
    output:
        md="<reports>/differences.md",
        html=report(
            "<reports>/differences.html",
            caption="../report/differences.rst",
            category=section("Verdicts"),
            labels={
                "item": "Differences: the article's statements beside our numbers"
            },
        ),
    log:
        "<logs>/differences.log",
    conda:
        "../envs/ptl.yaml"
    params:
        environments=entries(),
        looks=looks(),
        code=code_digest("ptl.report.differences"),
    message:
        "Comparing the run with the article's statements"
    script:
        "../scripts/explain_differences.py"


rule claims:
    input:
        rules.judge_claims.output,
        rules.explain_differences.output,
        rules.cover.output if DECISION else [],
