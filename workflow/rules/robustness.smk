# The robustness study: one job per setting, verdicts as in the main run, and the unknowns that affect them.
# Not part of `rule all`; `snakemake -j2 robustness` makes it.

from ptl.study.robustness.design import StudyJobs

STUDY = config["robustness"]["study"]
# read only when the study is asked for
SETTINGS = StudyJobs(STUDY, OWN_CONFIG, refuse)


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
        job=lambda wildcards: json.dumps(
            SETTINGS.by_name[wildcards.setting], sort_keys=True
        ),
        maps=map_digests(),
        code=code_digest(
            "ptl.study.robustness.running",
            *method_modules(METHODS),
        ),
    message:
        "Learning the setting {wildcards.setting} of the robustness study"
    shell:
        "ptl robustness --job {params.job:q} --output {output:q} 2> {log:q}"


rule judge_setting:
    input:
        "<results>/robustness/{setting}.h5",
    output:
        verdicts="<results>/robustness/{setting}.verdicts.csv",
        targets="<results>/robustness/{setting}.targets.csv",
    log:
        "<logs>/robustness/{setting}.judge.log",
    wildcard_constraints:
        setting="[a-z0-9_.]+",
    conda:
        "../envs/ptl.yaml"
    params:
        groups=groups("measures", "statistics", "growth"),
        asked=lambda wildcards: asked_jobs(
            {wildcards.setting: SETTINGS.by_name[wildcards.setting]}, map_digests()
        ),
        code=code_digest("ptl.study.robustness.verdicts"),
    message:
        "Judging the claims in the setting {wildcards.setting}"
    script:
        "../scripts/judge_setting.py"


rule report_robustness:
    input:
        study=STUDY,
        verdicts=lambda wildcards: [
            f"<results>/robustness/{name}.verdicts.csv" for name in SETTINGS.by_name
        ],
        targets=lambda wildcards: [
            f"<results>/robustness/{name}.targets.csv" for name in SETTINGS.by_name
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


rule robustness:
    input:
        rules.report_robustness.output,
