# The front page of the report, and the manifest of everything in it.


report: os.path.abspath(f"reports/{config['run']}/front_page.rst")


rule front_page:
    input:
        claims=rules.judge_claims.output.csv,
        metrics=rules.tabulate.output.metrics,
    output:
        "<reports>/front_page.rst",
    log:
        "<logs>/front_page.log",
    conda:
        "../envs/ptl.yaml"
    params:
        environments=" ".join(
            shlex.join(["--environment", f"{name}={LAST_TASK[name]}={title_of(name)}"])
            for name in ENVIRONMENTS
        ),
        methods=" ".join(f"--method {method}" for method in METHODS),
        code=code_digest("ptl.commands.front_page", "ptl.front_page"),
        labels=method_colours(),
    message:
        "Composing the front page of the report"
    shell:
        "ptl front-page {input.claims:q} {input.metrics:q} {params.environments} {params.methods}"
        " --output {output:q} 2> {log:q}"


rule manifest:
    input:
        rules.tables.input,
        rules.figures.input,
        rules.claims.input,
        rules.report_fv.output,
        rules.front_page.output,
    output:
        "<reports>/manifest.json",
    log:
        "<logs>/manifest.log",
    conda:
        "../envs/ptl.yaml"
    params:
        folder=lambda wildcards, output: os.path.dirname(output[0]),
        config=json.dumps(config, sort_keys=True),
        code=code_digest("ptl.commands.manifest", "ptl.manifest"),
    message:
        "Writing the manifest of all products"
    shell:
        "ptl manifest {input:q} --folder {params.folder:q} --config {params.config:q} --output {output:q} 2> {log:q}"
