# One job per life of many random tasks: how the library grows.


rule grow:
    input:
        map=config["environments"][config["growth"]["environment"]]["map"],
    output:
        "<results>/growth/run_{run}.h5",
    log:
        "<logs>/growth/run_{run}.log",
    conda:
        "../envs/ptl.yaml"
    params:
        growth=config["growth"],
        run=lambda wildcards: int(wildcards.run),
        root_seed=config["root_seed"],
        map=DIGESTS[config["growth"]["environment"]],
        parameters=hyper_parameters("learning", "skills", "subgoals"),
        code=code_digest("ptl.learning.growth", "ptl.methods.ptl", "ptl.files.results"),
    message:
        "Growing a library over random tasks, run {wildcards.run}"
    shell:
        "ptl grow --map {input.map:q} --environment {params.growth[environment]} --tasks {params.growth[tasks]}"
        " --run {params.run} --root-seed {params.root_seed}"
        " --parameters {params.parameters:q} --output {output:q} 2> {log:q}"


rule growth:
    input:
        expand("<results>/growth/run_{run:03d}.h5", run=range(config["growth"]["runs"])),
