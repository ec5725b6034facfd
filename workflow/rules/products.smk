# The front page of the report, and the manifest of all products.


report: os.path.abspath(prefixed(REPORTS / "front_page.rst"))


rule front_page:
    input:
        **({"claims": rules.judge_claims.output.csv} if ARTICLE else {}),
        **({"front": "<reports>/figures/front.csv"} if "front" in FIGURES else {}),
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
            name: (heading(name, row), row.caption, row.module == "maps")
            for name, row in on_page(FIGURES).items()
        },
        front=FIGURES["front"].caption if "front" in FIGURES else "",
        tables=TABLES | ({"coverage": "Coverage of the intervals"} if DECISION else {}),
        run=config["run"],
        code=code_digest("ptl.report.front_page"),
    message:
        "Composing the front page of the report and {output.page}"
    script:
        "../scripts/front_page.py"


ASKED = {"config": config, "maps": DIGESTS, "foreign": FOREIGN_DIGESTS}
CODES = {rule.name: rule.params.get("code") for rule in workflow.rules}
CODES = {name: code for name, code in CODES.items() if isinstance(code, str)}

if workflow.is_main_process:
    aging.age_products(PLACE, Path(prefixed(REPORTS)), ASKED, CODES)


rule manifest:
    input:
        rules.tables.input,
        rules.figures.input,
        rules.claims.input if ARTICLE else [],
        rules.front_page.output,
        rules.explorer.input,
    output:
        manifest="<reports>/manifest.json",
        # records which products were made here, not just checked out
        made="<results>/made.json",
    log:
        "<logs>/manifest.log",
    conda:
        "../envs/ptl.yaml"
    params:
        asked=ASKED,
        codes=CODES,
        jobs=packed(job for place, job in JOBS.items() if place not in BATCHES),
        code=code_digest("ptl.files.manifest", "ptl.files.aging"),
    message:
        "Writing the manifest of all products"
    script:
        "../scripts/manifest.py"
