# One job per life of many random tasks: how the library grows.


rule grow:
    input:
        map=map_files([config["growth"]["environment"]]),
    output:
        "<results>/growth/run_{run}.h5",
    log:
        "<logs>/growth/run_{run}.log",
    priority: 0 if ARTICLE else -1
    conda:
        "../envs/ptl.yaml"
    params:
        job=job_of,
        maps=maps_of,
    message:
        "Growing a library over random tasks, run {wildcards.run}"
    shell:
        "ptl run --job {params.job:q} {params.maps:q} --output {output:q} 2> {log:q}"


rule growth:
    input:
        files_of(GROWTH),
