# One job per environment, method and seed: a life of tasks, learned in order.


rule learn:
    input:
        map=lambda wildcards: map_files([wildcards.environment]),
    output:
        "<results>/learning/{environment}/{method}/seed_{seed}.h5",
    log:
        "<logs>/learning/{environment}/{method}/seed_{seed}.log",
    # Before the small jobs, so that these fill the cores while the results are measured.
    priority: 1
    conda:
        "../envs/ptl.yaml"
    params:
        job=job_of,
        maps=maps_of,
    message:
        "Learning {wildcards.environment} with {wildcards.method}, seed {wildcards.seed}"
    shell:
        "ptl run --job {params.job:q} {params.maps:q} --output {output:q} 2> {log:q}"


rule learning:
    input:
        files_of(LEARNING),
