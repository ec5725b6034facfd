# One job per environment, method and seed: a life of tasks, learned in order.


rule learn:
    input:
        map=map_of,
    output:
        "<results>/learning/{environment}/{method}/seed_{seed}.h5",
    log:
        "<logs>/learning/{environment}/{method}/seed_{seed}.log",
    # After the survey and before the small jobs, so that these fill the cores while the results are measured.
    priority: 1
    conda:
        "../envs/ptl.yaml"
    params:
        seed=lambda wildcards: int(wildcards.seed),
        root_seed=config["root_seed"],
        map=lambda wildcards: DIGESTS[wildcards.environment],
        tasks=lambda wildcards: config["environments"][wildcards.environment]["tasks"],
        parameters=hyper_parameters("learning", "skills", "subgoals", "policy_reuse"),
        method=lambda wildcards: REFERENCES[wildcards.method],
        own=lambda wildcards: json.dumps(own_parameters(wildcards.method)),
        code=lambda wildcards: CODES[wildcards.method],
    message:
        "Learning {wildcards.environment} with {wildcards.method}, seed {wildcards.seed}"
    shell:
        "ptl learn --map {input.map:q} --environment {wildcards.environment} --tasks {params.tasks}"
        " --method {params.method:q} --method-parameters {params.own:q} --seed {params.seed} --root-seed {params.root_seed}"
        " --parameters {params.parameters:q} --output {output:q} 2> {log:q}"


rule learning:
    input:
        learning_files(),
