# Fernandez and Veloso's own experiment, learned by the policy reuse of the main comparison.

FV_LIBRARIES = ["q_learning", "library_234", "library_1234", "library_2345"]


rule learn_fv:
    input:
        # their map, whatever environments the run compares
        map="config/environments/env3.txt",
    output:
        "<results>/fernandez_veloso/{library}.h5",
    log:
        "<logs>/fernandez_veloso/{library}.log",
    wildcard_constraints:
        library="|".join(FV_LIBRARIES),
    conda:
        "../envs/ptl.yaml"
    params:
        seeds=config["seeds"],
        root_seed=config["root_seed"],
        code=code_digest(
            "ptl.fv_experiment", "ptl.methods.policy_reuse", "ptl.methods.no_transfer"
        ),
    message:
        "Learning in the setting of Fernandez and Veloso, {wildcards.library}"
    shell:
        "ptl fv learn --map {input.map:q} --library {wildcards.library} --seeds {params.seeds}"
        " --root-seed {params.root_seed} --output {output:q} 2> {log:q}"


rule report_fv:
    input:
        expand("<results>/fernandez_veloso/{library}.h5", library=FV_LIBRARIES),
    output:
        png=report(
            "<reports>/figures/policy_reuse_fv.png",
            caption="../report/fv.rst",
            category="5 Checks",
            labels={
                "item": "Policy reuse",
                "shows": "gain in Fernandez and Veloso's own experiment",
            },
        ),
        twins=multiext("<reports>/figures/policy_reuse_fv", ".svg", ".csv"),
        page=report(
            "<reports>/tables/policy_reuse_fv.html",
            caption="../report/fv.rst",
            category="5 Checks",
            labels={
                "item": "Policy reuse",
                "shows": "gain over all trials, table",
            },
        ),
        table=multiext("<reports>/tables/policy_reuse_fv", ".csv", ".md"),
    log:
        "<logs>/fernandez_veloso/report.log",
    conda:
        "../envs/ptl.yaml"
    params:
        confidence=config["statistics"]["confidence"],
        resamples=config["statistics"]["resamples"],
        code=code_digest(
            "ptl.commands.fv",
            "ptl.fv_table",
            "ptl.figures.fv",
            "ptl.methods.no_transfer",
        ),
    message:
        "Drawing the gain of policy reuse beside the published one"
    shell:
        "ptl fv report {input:q} --output-figure {output.png:q} --output-table {output.table[0]:q}"
        " --confidence {params.confidence} --resamples {params.resamples} 2> {log:q}"


rule fernandez_veloso:
    input:
        rules.report_fv.output,
