# A small map of our own on which the prior misleads, for the figure that shows how the likelihood recovers.

from ptl.files.question import MISLEADING, SIDE_TASKS


rule learn_misleading:
    input:
        map=SIDE_MAPS[MISLEADING],
    output:
        "<results>/misleading_prior/seed_{seed}.h5",
    log:
        "<logs>/misleading_prior/seed_{seed}.log",
    conda:
        "../envs/ptl.yaml"
    params:
        seed=lambda wildcards: int(wildcards.seed),
        tasks=SIDE_TASKS,
        root_seed=config["root_seed"],
        map=DIGESTS[MISLEADING],
        parameters=hyper_parameters("learning", "skills", "subgoals", "policy_reuse"),
        code=code_digest("ptl.learning.life", "ptl.methods.ptl", "ptl.files.results"),
    message:
        "Learning the map where the prior misleads, seed {wildcards.seed}"
    shell:
        "ptl learn --map {input.map:q} --environment misleading_prior --tasks {params.tasks} --method ptl"
        " --seed {params.seed} --root-seed {params.root_seed}"
        " --parameters {params.parameters:q} --output {output:q} 2> {log:q}"


rule misleading_prior_learning:
    input:
        expand(
            "<results>/misleading_prior/seed_{seed:03d}.h5",
            seed=SEEDS if "ptl" in METHODS else [],
        ),
