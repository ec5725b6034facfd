# A self-contained page that shows the learning of some seeds.

# A few seeds show how much runs differ; with more the page would be too large for the report (see `pack`).
EXPLORED = learning_of(seeds=3)


rule build_explorer:
    input:
        files_of(EXPLORED),
    output:
        report(
            "<reports>/explorer.html",
            caption="../report/explorer.rst",
            category=section("Explorer"),
            labels={
                "item": "Explorer",
                "shows": "values, policies, skills and episodes, to play with",
            },
        ),
    log:
        "<logs>/explorer.log",
    conda:
        "../envs/ptl.yaml"
    params:
        groups=groups("measures"),
        jobs=packed(EXPLORED.values()),
        environments=entries(),
        given={
            name: [REFERENCES[name], RUN.method_parameters.get(name, {})]
            for name in METHODS
        },
        looks=looks(),
        code=code_digest(
            "ptl.report.explorer.data",
            "ptl.report.explorer.page",
            *method_modules(METHODS),
        ),
    message:
        "Building the explorer {output}"
    script:
        "../scripts/build_explorer.py"


rule explorer:
    input:
        rules.build_explorer.output,
