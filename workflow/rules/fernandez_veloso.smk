# An experiment after Fernandez and Veloso, learned by the policy reuse of the main comparison. Its figure is drawn with the
# others.

from ptl.files.question import POLICY_REUSE
from ptl.files.schema import GAIN
from ptl.study.policy_reuse_experiment import ARMS


rule learn_fv:
    input:
        # their map, whatever environments the run compares
        map=SIDE_MAPS[POLICY_REUSE],
    output:
        "<results>/fernandez_veloso/{library}.h5",
    log:
        "<logs>/fernandez_veloso/{library}.log",
    wildcard_constraints:
        library="|".join(ARMS),
    conda:
        "../envs/ptl.yaml"
    params:
        seeds=config["seeds"],
        root_seed=config["root_seed"],
        map=DIGESTS[POLICY_REUSE],
        code=code_digest(
            "ptl.study.policy_reuse_experiment",
            "ptl.methods.policy_reuse",
            "ptl.methods.no_transfer",
        ),
    message:
        "Learning in the setting of Fernandez and Veloso, {wildcards.library}"
    shell:
        "ptl fv --map {input.map:q} --library {wildcards.library} --seeds {params.seeds}"
        " --root-seed {params.root_seed} --output {output:q} 2> {log:q}"


rule fernandez_veloso_learning:
    input:
        expand("<results>/fernandez_veloso/{library}.h5", library=ARMS),


rule policy_reuse_table:
    input:
        rules.fernandez_veloso_learning.input,
    output:
        table=multiext("<reports>/tables/policy_reuse_fv", ".csv", ".md"),
        page=report(
            "<reports>/tables/policy_reuse_fv.html",
            caption="../report/fv.rst",
            category=section("Checks"),
            labels={
                # as the figure's: Snakemake's report fails where both labels of two items differ
                "item": FIGURES["policy_reuse_fv"].item,
                "shows": "gain over all trials, table",
            },
        ),
    log:
        "<logs>/fernandez_veloso/report.log",
    conda:
        "../envs/ptl.yaml"
    params:
        groups=groups("statistics"),
        asked=asked(GAIN),
        code=code_digest("ptl.report.policy_reuse_experiment"),
    message:
        "Tabulating the gain of policy reuse beside the published one"
    script:
        "../scripts/policy_reuse_table.py"


rule fernandez_veloso:
    input:
        rules.policy_reuse_table.output,
        expand(
            "<reports>/figures/policy_reuse_fv.{format}", format=["png", "svg", "csv"]
        ),
