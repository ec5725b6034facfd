# The robustness study: one job per setting, the same verdicts as the main run's, and what they hang on.
# Not part of `rule all`; `snakemake -j2 robustness` makes it.

from ptl.robustness.design import StudyJobs

STUDY = config.get("robustness", {}).get("study", "config/robustness.yaml")
# read only when the study is asked for
SETTINGS = StudyJobs(STUDY, config, refuse)


rule learn_setting:
    input:
        [environment["map"] for environment in config["environments"].values()],
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
        code=code_digest(
            "ptl.robustness.running", *[f"ptl.methods.{method}" for method in METHODS]
        ),
    message:
        "Learning the setting {wildcards.setting} of the robustness study"
    shell:
        "ptl robustness learn --job {params.job:q} --output {output:q} 2> {log:q}"


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
        options=f"--window {config['measures']['window']}"
        f" --threshold-factor {config['measures']['threshold_factor']}"
        f" --confidence {config['statistics']['confidence']}"
        f" --resamples {config['statistics']['resamples']}",
        code=code_digest("ptl.robustness.verdicts"),
    message:
        "Judging the claims in the setting {wildcards.setting}"
    shell:
        "ptl robustness judge {input:q} {params.options} --output-verdicts {output.verdicts:q}"
        " --output-targets {output.targets:q} 2> {log:q}"


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
            category="6 Robustness",
            labels={"item": "Robustness", "shows": "every claim in every setting"},
        ),
        twins=multiext("<reports>/robustness/heat_map", ".svg", ".csv"),
        share=report(
            "<reports>/robustness/share.html",
            caption="../report/robustness.rst",
            category="6 Robustness",
            labels={
                "item": "Robustness",
                "shows": "share of settings in which each claim holds",
            },
        ),
        unknowns=report(
            "<reports>/robustness/unknowns.html",
            caption="../report/robustness.rst",
            category="6 Robustness",
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
        folder=lambda wildcards, input: os.path.dirname(input.verdicts[0]),
        output=lambda wildcards, output: os.path.dirname(output.png),
        code=code_digest(
            "ptl.commands.robustness",
            "ptl.robustness.summary",
            "ptl.robustness.pages",
            "ptl.figures.robustness",
        ),
    message:
        "Putting the verdicts of all settings together"
    shell:
        "ptl robustness report {params.folder:q} --study {input.study:q} --output-folder {params.output:q} 2> {log:q}"


rule robustness:
    input:
        rules.report_robustness.output,
