# The robustness study: one job per setting, verdicts as in the main run by groups of settings, and the unknowns that
# affect them.
# Not part of `rule all`; `snakemake -j2 robustness` makes it.


rule learn_setting:
    input:
        [entry["map"] for entry in entries().values()],
    output:
        "<results>/robustness/{setting}.h5",
    log:
        "<logs>/robustness/{setting}.log",
    wildcard_constraints:
        setting="[a-z0-9_.]+",
    conda:
        "../envs/ptl.yaml"
    params:
        job=lambda wildcards: json.dumps(settings()[wildcards.setting], sort_keys=True),
        maps=map_digests(),
        code=code_digest(
            "ptl.study.robustness.running",
            *method_modules(METHODS),
        ),
    message:
        "Learning the setting {wildcards.setting} of the robustness study"
    shell:
        "ptl robustness --job {params.job:q} --output {output:q} 2> {log:q}"


rule judge_settings:
    input:
        lambda wildcards: [
            f"<results>/robustness/{name}.h5" for name in settings_of(wildcards.group)
        ],
    output:
        verdicts="<results>/robustness/{group}.verdicts.csv",
        targets="<results>/robustness/{group}.targets.csv",
    log:
        "<logs>/robustness/{group}.judge.log",
    wildcard_constraints:
        group="|".join(GROUPS),
    conda:
        "../envs/ptl.yaml"
    params:
        groups=groups("measures", "statistics", "growth"),
        asked=lambda wildcards: asked_settings(settings_of(wildcards.group)),
        code=code_digest("ptl.study.robustness.verdicts"),
    message:
        "Judging the claims in the group {wildcards.group} of settings"
    script:
        "../scripts/judge_settings.py"


rule report_robustness:
    input:
        study=STUDY,
        verdicts=lambda wildcards: [
            f"<results>/robustness/{group}.verdicts.csv" for group in used_groups()
        ],
        targets=lambda wildcards: [
            f"<results>/robustness/{group}.targets.csv" for group in used_groups()
        ],
    output:
        png=report(
            "<reports>/robustness/heat_map.png",
            caption="../report/robustness.rst",
            category=section("Robustness"),
            labels={"item": "Robustness", "shows": "every claim in every setting"},
        ),
        twins=multiext("<reports>/robustness/heat_map", ".svg", ".csv"),
        share=report(
            "<reports>/robustness/share.html",
            caption="../report/robustness.rst",
            category=section("Robustness"),
            labels={
                "item": "Robustness",
                "shows": "share of settings in which each claim holds",
            },
        ),
        unknowns=report(
            "<reports>/robustness/unknowns.html",
            caption="../report/robustness.rst",
            category=section("Robustness"),
            labels={"item": "Robustness", "shows": "unknowns ranked"},
        ),
        tables=expand(
            "<reports>/robustness/{table}",
            table=[
                "share.csv",
                "share.md",
                "unknowns.csv",
                "unknowns.md",
                "verdicts.csv",
                "settings.csv",
                "targeted.csv",
                "targeted.md",
            ],
        ),
    log:
        "<logs>/robustness/report.log",
    conda:
        "../envs/ptl.yaml"
    params:
        code=code_digest(
            "ptl.study.robustness.summary",
            "ptl.report.robustness",
            "ptl.report.figures.robustness",
        ),
    message:
        "Summarising the verdicts of all settings"
    script:
        "../scripts/report_robustness.py"


STUDY_CODES = codes_of(workflow.rules)
STUDY_DIGEST = digest_of(
    sha256(Path(STUDY)) if os.path.isfile(STUDY) else "",
    OWN_CONFIG,
    DIGESTS,
    STUDY_CODES,
)


rule check_robustness:
    input:
        rules.report_robustness.output,
    output:
        made="<results>/robustness/made.json",
        # is missing as long as the study was not checked for this configuration, these maps and this code
        checked=f"<results>/robustness/checked/{STUDY_DIGEST}",
    log:
        "<logs>/robustness/check_robustness.log",
    conda:
        "../envs/ptl.yaml"
    params:
        config=lambda wildcards: json.dumps({**OWN_CONFIG, "study": study().to_dict()}),
        maps=DIGESTS,
        asked=lambda wildcards: asked_settings(settings()),
        codes=STUDY_CODES,
        code=code_digest("ptl.files.manifest", "ptl.files.records"),
    message:
        "Holding the robustness study against its settings"
    script:
        "../scripts/manifest.py"


rule robustness:
    input:
        # missing in a fresh checkout, whose pages in reports/ are there
        rules.report_robustness.input,
        rules.report_robustness.output,
        rules.check_robustness.output,
