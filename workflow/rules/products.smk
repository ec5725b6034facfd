# The front page of the report, and the manifest of all products.


report: os.path.abspath(f"reports/{config['run']}/front_page.rst")


rule front_page:
    input:
        **({"claims": rules.judge_claims.output.csv} if ARTICLE else {}),
        metrics=rules.tabulate.output.metrics,
    output:
        text="<reports>/front_page.rst",
        page="<reports>/index.html",
    log:
        "<logs>/front_page.log",
    conda:
        "../envs/ptl.yaml"
    params:
        environments=entries(),
        looks=looks(),
        foreign=FOREIGN,
        figures={
            name: (f"{item_label(name, row)}: {row.shows}", row.caption)
            for name, row in FIGURES.items()
        },
        tables=TABLES,
        code=code_digest("ptl.report.front_page"),
    message:
        "Composing the front page of the report and {output.page}"
    script:
        "../scripts/front_page.py"


rule manifest:
    input:
        rules.tables.input,
        rules.figures.input,
        [rules.claims.input, rules.policy_reuse_table.output] if ARTICLE else [],
        rules.front_page.output,
        rules.explorer.input,
    output:
        manifest="<reports>/manifest.json",
        # tells products that were made here from those that were checked out
        made="<results>/made.json",
        # is missing as long as no manifest was written for this configuration, these maps and this code
        checked=f"<results>/checked/{digest_of(config, DIGESTS, QUESTION, codes_of(workflow.rules), FOREIGN_DIGESTS)}",
    log:
        "<logs>/manifest.log",
    conda:
        "../envs/ptl.yaml"
    params:
        config=json.dumps(config),
        maps=DIGESTS,
        asked={
            **QUESTION,
            **(asked_jobs(SETTING, DECISIONS, maps=map_digests()) if ARTICLE else {}),
        },
        codes=codes_of(workflow.rules),
        study=products_of_study(),
        code=code_digest("ptl.files.manifest", "ptl.files.records"),
    message:
        "Writing the manifest of all products"
    script:
        "../scripts/manifest.py"
