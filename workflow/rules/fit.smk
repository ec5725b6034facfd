# The search for drawings and settings that fit the article's claims, in one job.
# Not part of `rule all`; `snakemake -j2 fit` makes it.


rule search_fit:
    input:
        search=SEARCH,
    output:
        tried="<reports>/fit/tried.csv",
        parts="<reports>/fit/parts.csv",
        halves="<reports>/fit/halves.csv",
        # is missing as long as the search was not made for this configuration, these maps and this code
        searched=f"<results>/searched/{search_digest()}",
    log:
        "<logs>/fit/search.log",
    conda:
        "../envs/ptl.yaml"
    params:
        lives=f"results/{config['run']}/fit",
        reports=subpath(output.tried, parent=True),
        config=json.dumps(OWN_CONFIG, sort_keys=True),
        code=SEARCH_CODE,
    message:
        "Searching for drawings and settings that fit the claims"
    shell:
        "ptl fit --search {input.search:q} --config {params.config:q} --lives {params.lives:q}"
        " --output {params.reports:q} 2> {log:q} && touch {output.searched:q}"


rule report_fit:
    input:
        tried=rules.search_fit.output.tried,
        halves=rules.search_fit.output.halves,
        search=rules.search_fit.input.search,
    output:
        page="<reports>/fit/fit.md",
        pages=expand(
            "<reports>/fit/{table}.html",
            table=["decided", "halves", "claims", "screened"],
        ),
    log:
        "<logs>/fit/report.log",
    conda:
        "../envs/ptl.yaml"
    params:
        code=code_digest("ptl.report.fit", "ptl.study.fit"),
    message:
        "Describing the search"
    script:
        "../scripts/report_fit.py"


rule fit:
    input:
        rules.search_fit.output,
        rules.report_fit.output,
