# The front page of the report, and the manifest of everything in it.

FRONT_PAGE = REPORTS + "/front_page.rst"


report: os.path.abspath(FRONT_PAGE)


rule front_page:
    input:
        claims=rules.judge_claims.output.csv,
        metrics=rules.tabulate.output.metrics,
    output:
        FRONT_PAGE,
    log:
        "logs/" + RESULTS + "/front_page.log",
    conda:
        "../envs/ptl.yaml"
    params:
        environments=" ".join(
            "--environment "
            + shlex.quote(f"{name}={LAST_TASK[name]}={title_of(name)}")
            for name in ENVIRONMENTS
        ),
        methods=" ".join(f"--method {method}" for method in METHODS),
        code=code_digest("ptl.commands.front_page", "ptl.front_page"),
        labels=method_colours(),
    message:
        "Composing the front page of the report"
    shell:
        PTL
        + " front-page {input.claims:q} {input.metrics:q} {params.environments} {params.methods}"
        " --output {output:q} 2> {log:q}"


rule manifest:
    input:
        rules.tables.input,
        rules.figures.input,
        rules.claims.input,
        rules.report_fv.output,
        rules.front_page.output,
    output:
        REPORTS + "/manifest.json",
    log:
        "logs/" + RESULTS + "/manifest.log",
    conda:
        "../envs/ptl.yaml"
    params:
        folder=REPORTS,
        config=json.dumps(config, sort_keys=True),
        code=code_digest("ptl.commands.manifest", "ptl.manifest"),
    message:
        "Writing the manifest of all products"
    shell:
        PTL
        + " manifest {input:q} --folder {params.folder:q} --config {params.config:q} --output {output:q} 2> {log:q}"
