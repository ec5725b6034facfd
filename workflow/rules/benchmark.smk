# What the package costs on this machine. Not part of `rule all`; `make benchmark` makes it.
#
# More threads than any machine has are scaled down to all cores, so nothing else runs beside a measurement.


rule compare_speed:
    input:
        map=config["environments"][ENVIRONMENTS[0]]["map"],
    output:
        page="<reports>/benchmark.md",
        table="<reports>/benchmark.csv",
    log:
        "<logs>/compare_speed.log",
    conda:
        "../envs/ptl.yaml"
    threads: 1024
    params:
        task=LAST_TASK[ENVIRONMENTS[0]],
        methods=" ".join(f"--method {method}" for method in METHODS),
        learning_jobs=len(ENVIRONMENTS) * len(METHODS) * len(SEEDS),
        code=code_digest("ptl.commands.benchmark", "ptl.benchmark.mushroom"),
        methods_code=method_colours(),
    message:
        "Timing the kernel beside other learners, and taking a learning job and a whole run apart"
    shell:
        "ptl benchmark speed --map {input.map:q} --task {params.task} {params.methods}"
        " --learning-jobs {params.learning_jobs} --output {output.page:q} 2> {log:q}"


rule measure_scaling:
    input:
        map=config["environments"][config["growth"]["environment"]]["map"],
    output:
        png="<reports>/scaling.png",
        others=multiext("<reports>/scaling", ".svg", ".csv", ".md"),
    log:
        "<logs>/measure_scaling.log",
    conda:
        "../envs/ptl.yaml"
    threads: 1024
    params:
        code=code_digest(
            "ptl.commands.benchmark", "ptl.benchmark.probes", "ptl.methods.ptl"
        ),
    message:
        "Measuring how the cost grows with states, skills and tasks"
    shell:
        "ptl benchmark scaling --map {input.map:q} --output {output.png:q} 2> {log:q}"


rule benchmark:
    input:
        rules.compare_speed.output,
        rules.measure_scaling.output,
