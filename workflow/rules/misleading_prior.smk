# A small map of our own on which the prior misleads, for the figure that shows how the likelihood recovers.

MISLEADING_MAP = "config/misleading_prior.txt"


rule learn_misleading:
    input:
        map=MISLEADING_MAP,
    output:
        "<results>/misleading_prior/seed_{seed}.h5",
    log:
        "<logs>/misleading_prior/seed_{seed}.log",
    conda:
        "../envs/ptl.yaml"
    params:
        seed=lambda wildcards: int(wildcards.seed),
        root_seed=config["root_seed"],
        parameters=hyper_parameters("learning", "skills", "subgoals", "policy_reuse"),
        code=code_digest("ptl.learning.life", "ptl.methods.ptl", "ptl.files.results"),
    message:
        "Learning the map where the prior misleads, seed {wildcards.seed}"
    shell:
        "ptl learn --map {input.map:q} --environment misleading_prior --tasks ABC --method ptl"
        " --seed {params.seed} --root-seed {params.root_seed}"
        " --parameters {params.parameters:q} --output {output:q} 2> {log:q}"


rule misleading_prior_learning:
    input:
        expand(
            "<results>/misleading_prior/seed_{seed:03d}.h5",
            seed=SEEDS if "ptl" in METHODS else [],
        ),
