# From the files of all jobs to one row a seed.


rule measure:
    input:
        learning_files(),
    output:
        per_seed=REPORTS + "/tables/per_seed.csv",
        subgoals=REPORTS + "/tables/subgoals.csv",
        steps=RESULTS + "/steps.h5",
    log:
        "logs/" + RESULTS + "/measure.log",
    conda:
        "../envs/ptl.yaml"
    params:
        measures=f"--window {config['measures']['window']}"
        f" --threshold-factor {config['measures']['threshold_factor']}",
        code=code_digest("ptl.commands.measure", "ptl.measures"),
    message:
        "Measuring {config[run]}: jump start, asymptotic performance, threshold, totals, transfer ratio"
    shell:
        PTL
        + " measure {input:q} --output-per-seed {output.per_seed:q} --output-subgoals {output.subgoals:q}"
        " --output-steps {output.steps:q} {params.measures} 2> {log:q}"


rule collect_growth:
    input:
        rules.growth.input,
    output:
        REPORTS + "/tables/growth.csv",
    log:
        "logs/" + RESULTS + "/collect_growth.log",
    conda:
        "../envs/ptl.yaml"
    params:
        code=code_digest("ptl.commands.collect_growth"),
    message:
        "Collecting the growth of the library"
    shell:
        PTL + " collect-growth {input:q} --output {output:q} 2> {log:q}"


rule library_cost:
    input:
        [config["environments"][environment]["map"] for environment in ENVIRONMENTS],
    output:
        selection=REPORTS + "/tables/selection_cost.csv",
        storage=REPORTS + "/tables/library_bytes.csv",
    log:
        "logs/" + RESULTS + "/library_cost.log",
    conda:
        "../envs/ptl.yaml"
    params:
        code=code_digest("ptl.commands.library_cost", "ptl.complexity"),
    message:
        "Measuring what a skill selection and a library cost"
    shell:
        PTL
        + " library-cost {input:q} --output-selection {output.selection:q} --output-storage {output.storage:q}"
        " 2> {log:q}"
