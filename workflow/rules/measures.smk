# From the files of all jobs to one row a seed.


rule measure:
    input:
        learning_files(),
    output:
        per_seed=REPORTS + "/tables/per_seed.csv",
        subgoals=REPORTS + "/tables/subgoals.csv",
        steps=RESULTS + "/steps.h5",
    params:
        measures=f"--window {config['measures']['window']}"
        f" --threshold-factor {config['measures']['threshold_factor']}",
        code=code_digest("ptl.commands.measure", "ptl.measures"),
    log:
        "logs/" + RESULTS + "/measure.log",
    message:
        "Measuring {config[run]}: jump start, asymptotic performance, threshold, totals, transfer ratio"
    conda:
        "../envs/ptl.yaml"
    shell:
        PTL + " measure {input:q} --output-per-seed {output.per_seed:q} --output-subgoals {output.subgoals:q}"
        " --output-steps {output.steps:q} {params.measures} 2> {log:q}"
