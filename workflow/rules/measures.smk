# From the files of all jobs to one row a seed.


rule measure:
    input:
        learning_files(),
    output:
        per_seed="<reports>/tables/per_seed.csv",
        subgoals="<reports>/tables/subgoals.csv",
        steps="<results>/steps.h5",
    log:
        "<logs>/measure.log",
    priority: 1
    conda:
        "../envs/ptl.yaml"
    params:
        files=numbered_learning_files(),
        measures=f"--window {config['measures']['window']}"
        f" --threshold-factor {config['measures']['threshold_factor']}",
        code=code_digest("ptl.commands.measure", "ptl.measures"),
    message:
        "Measuring {config[run]}: jump start, asymptotic performance, threshold, totals, transfer ratio"
    shell:
        "ptl measure {params.files:q} --output-per-seed {output.per_seed:q} --output-subgoals {output.subgoals:q}"
        " --output-steps {output.steps:q} {params.measures} 2> {log:q}"


rule collect_growth:
    input:
        rules.growth.input,
    output:
        "<reports>/tables/growth.csv",
    log:
        "<logs>/collect_growth.log",
    conda:
        "../envs/ptl.yaml"
    params:
        files=numbered("growth/run_[].h5", config["growth"]["runs"]),
        code=code_digest("ptl.commands.collect_growth"),
    message:
        "Collecting the growth of the library"
    shell:
        "ptl collect-growth {params.files:q} --output {output:q} 2> {log:q}"


rule library_cost:
    input:
        [config["environments"][environment]["map"] for environment in ENVIRONMENTS],
    output:
        selection="<reports>/tables/selection_cost.csv",
        storage="<reports>/tables/library_bytes.csv",
    log:
        "<logs>/library_cost.log",
    conda:
        "../envs/ptl.yaml"
    params:
        code=code_digest("ptl.commands.library_cost", "ptl.complexity"),
    message:
        "Measuring what a skill selection and a library cost"
    shell:
        "ptl library-cost {input:q} --output-selection {output.selection:q} --output-storage {output.storage:q}"
        " 2> {log:q}"
