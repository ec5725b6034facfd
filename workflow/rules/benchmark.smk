# The cost of the package on this machine. Not part of `rule all`; `make benchmark` makes it.
#
# More threads than any machine has are scaled down to all cores, so nothing else runs beside a measurement.


rule compare_speed:
    input:
        map=config["environments"][ENVIRONMENTS[0]]["map"],
        surveyed=[entry["map"] for entry in entries().values()],
    output:
        page="<reports>/benchmark.md",
        table="<reports>/benchmark.csv",
    log:
        "<logs>/compare_speed.log",
    conda:
        "../envs/ptl.yaml"
    threads: 1024
    params:
        task=config["environments"][ENVIRONMENTS[0]]["tasks"][-1],
        config=OWN_CONFIG,
        code=code_digest(
            "ptl.benchmark.pages",
            "ptl.benchmark.numba_loop",
            "ptl.benchmark.figure8",
            "ptl.benchmark.probes",
        ),
        methods_code=method_modules(METHODS),
    message:
        "Timing the kernel beside other learners, figure 8 by two methods, learning jobs and a whole run"
    script:
        "../scripts/compare_speed.py"


rule measure_scaling:
    input:
        map=config["environments"][config["growth"]["environment"]]["map"],
    output:
        png="<reports>/scaling.png",
        page="<reports>/scaling.md",
        others=multiext("<reports>/scaling", ".svg", ".csv"),
    log:
        "<logs>/measure_scaling.log",
    conda:
        "../envs/ptl.yaml"
    threads: 1024
    params:
        code=code_digest(
            "ptl.benchmark.scaling", "ptl.benchmark.probes", "ptl.methods.ptl"
        ),
    message:
        "Measuring how the cost grows with states, skills and tasks"
    script:
        "../scripts/measure_scaling.py"


rule benchmark:
    input:
        rules.compare_speed.output,
        rules.measure_scaling.output,
