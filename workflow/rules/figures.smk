# The article's figures. Each one is a PNG for reading, an SVG for printing and a CSV of the numbers drawn.

FIGURES = REPORTS + "/figures/"
CONFIDENCE = config["statistics"]["confidence"]
# On the first environment the base never reaches the threshold, so the second shows the measures better.
MEASURES_SHOWN_IN = ENVIRONMENTS[min(1, len(ENVIRONMENTS) - 1)]
LAST_TASK = {
    name: environment["tasks"][-1]
    for name, environment in config["environments"].items()
}


def article_item(environment, kind):
    """Name of the figure of an environment: the article's number, or one made from the environment's name."""
    return (
        config["environments"][environment]
        .get("article_items", {})
        .get(kind, f"{kind}_{environment}")
    )


MAP_FIGURES = {
    article_item(environment, "map"): environment for environment in ENVIRONMENTS
}
DISCOVERY_FIGURES = {
    article_item(environment, "discovery"): environment for environment in ENVIRONMENTS
}


def map_titles():
    """The environments' titles as quoted options of the drawing commands."""
    return " ".join(
        "--title " + shlex.quote(f"{name}={title_of(name)}") for name in ENVIRONMENTS
    )


def drawing_code(module):
    """Digest of what one figure is made by."""
    return code_digest("ptl.figures.style", f"ptl.figures.{module}")


def method_colours():
    """Digest of the files that give the methods their names and colours."""
    return code_digest(*[f"ptl.methods.{method}" for method in METHODS])


def map_options():
    """The environments with their maps as quoted options of the drawing commands."""
    maps = {
        name: environment["map"] for name, environment in config["environments"].items()
    }
    return " ".join(
        "--map " + shlex.quote(f"{name}={path}") for name, path in maps.items()
    )


def last_task_options():
    """The environments with their last tasks as options of the drawing commands."""
    return " ".join(f"--task {name}={task}" for name, task in LAST_TASK.items())


def discovery_tasks(environment):
    """Letters of the tasks that the discovery figure shows; the last three if the configuration names none."""
    entry = config["environments"][environment]
    return entry["discovery_tasks"] or entry["tasks"][-3:]


def curve_methods():
    """Methods of the learning curves: the article's four, and those that only this run compares."""
    variants = {"ptl_supervised", "ptl_unknown_goal"}
    return " ".join(
        f"--method {method}" for method in METHODS if method not in variants
    )


rule draw_prior:
    input:
        map=config["environments"][ENVIRONMENTS[-1]]["map"],
    output:
        png=report(
            FIGURES + "figure03.png",
            caption="../report/figure.rst",
            category="2 Figures",
            labels={"item": "Figure 3", "shows": "prior of a skill by where it ends"},
        ),
        twins=multiext(FIGURES + "figure03", ".svg", ".csv"),
    log:
        "logs/" + RESULTS + "/figures/figure03.log",
    conda:
        "../envs/ptl.yaml"
    params:
        goal=LAST_TASK[ENVIRONMENTS[-1]],
        title=title_of(ENVIRONMENTS[-1]),
        form=config["skills"]["prior_form"],
        width=config["skills"]["prior_width"],
        code=drawing_code("prior"),
    message:
        "Drawing the prior of a skill"
    shell:
        PTL
        + " figure prior {input.map:q} --goal {params.goal} --form {params.form} --width {params.width}"
        " --title {params.title:q} --output {output.png:q} 2> {log:q}"


rule learn_misleading:
    input:
        map="config/misleading_prior.txt",
    output:
        RESULTS + "/misleading_prior/seed_{seed}.h5",
    log:
        "logs/" + RESULTS + "/misleading_prior/seed_{seed}.log",
    conda:
        "../envs/ptl.yaml"
    params:
        seed=lambda wildcards: int(wildcards.seed),
        root_seed=config["root_seed"],
        parameters=hyper_parameters("learning", "skills", "subgoals", "policy_reuse"),
        code=code_digest("ptl.learning", "ptl.methods.ptl", "ptl.store"),
    message:
        "Learning the map where the prior misleads, seed {wildcards.seed}"
    shell:
        PTL
        + " learn --map {input.map:q} --environment misleading_prior --tasks ABC --method ptl"
        " --seed {params.seed} --root-seed {params.root_seed}"
        " --parameters {params.parameters:q} --output {output:q} 2> {log:q}"


rule draw_misleading_prior:
    input:
        expand(RESULTS + "/misleading_prior/seed_{seed:03d}.h5", seed=SEEDS),
    output:
        png=report(
            FIGURES + "figure04.png",
            caption="../report/figure.rst",
            category="2 Figures",
            labels={
                "item": "Figure 4",
                "shows": "the likelihood overrules a misleading prior",
            },
        ),
        twins=multiext(FIGURES + "figure04", ".svg", ".csv"),
    log:
        "logs/" + RESULTS + "/figures/figure04.log",
    conda:
        "../envs/ptl.yaml"
    params:
        confidence=CONFIDENCE,
        code=drawing_code("misleading_prior"),
    message:
        "Drawing how the likelihood overrules a misleading prior"
    shell:
        PTL
        + " figure misleading-prior {input:q} --confidence {params.confidence} --output {output.png:q} 2> {log:q}"


rule draw_map:
    input:
        map=lambda wildcards: config["environments"][MAP_FIGURES[wildcards.figure]][
            "map"
        ],
    output:
        png=report(
            FIGURES + "{figure}.png",
            caption="../report/figure.rst",
            category="2 Figures",
            labels={"item": "{figure}", "shows": "map with start and goals"},
        ),
        twins=multiext(FIGURES + "{figure}", ".svg", ".csv"),
    log:
        "logs/" + RESULTS + "/figures/{figure}.log",
    wildcard_constraints:
        figure="|".join(MAP_FIGURES),
    conda:
        "../envs/ptl.yaml"
    params:
        title=lambda wildcards: title_of(MAP_FIGURES[wildcards.figure]),
        code=drawing_code("maps"),
    message:
        "Drawing the map {wildcards.figure}"
    shell:
        PTL
        + " figure map {input.map:q} --title {params.title:q} --output {output.png:q} 2> {log:q}"


rule draw_frequencies:
    input:
        rules.subgoal_frequencies.input,
    output:
        png=report(
            FIGURES + "figure08.png",
            caption="../report/figure.rst",
            category="2 Figures",
            labels={"item": "Figure 8", "shows": "subgoal selection frequencies"},
        ),
        twins=multiext(FIGURES + "figure08", ".svg", ".csv"),
    log:
        "logs/" + RESULTS + "/figures/figure08.log",
    conda:
        "../envs/ptl.yaml"
    params:
        titles=map_titles(),
        code=drawing_code("frequencies"),
    message:
        "Drawing subgoal selection frequencies"
    shell:
        PTL
        + " figure frequencies {input:q} {params.titles} --output {output.png:q} 2> {log:q}"


rule draw_discovery:
    input:
        lambda wildcards: learning_files([DISCOVERY_FIGURES[wildcards.figure]], ["ptl"]),
    output:
        png=report(
            FIGURES + "{figure}.png",
            caption="../report/figure.rst",
            category="2 Figures",
            labels={"item": "{figure}", "shows": "original and incremental FD metric"},
        ),
        twins=multiext(FIGURES + "{figure}", ".svg", ".csv"),
    log:
        "logs/" + RESULTS + "/figures/{figure}.log",
    wildcard_constraints:
        figure="|".join(DISCOVERY_FIGURES),
    conda:
        "../envs/ptl.yaml"
    params:
        title=lambda wildcards: title_of(DISCOVERY_FIGURES[wildcards.figure]),
        tasks=lambda wildcards: discovery_tasks(DISCOVERY_FIGURES[wildcards.figure]),
        code=drawing_code("discovery"),
    message:
        "Drawing subgoal discovery, {wildcards.figure}"
    shell:
        PTL
        + " figure discovery {input:q} --tasks {params.tasks} --title {params.title:q}"
        " --output {output.png:q} 2> {log:q}"


rule draw_curves:
    input:
        steps=rules.measure.output.steps,
        maps=[
            config["environments"][environment]["map"] for environment in ENVIRONMENTS
        ],
    output:
        png=report(
            FIGURES + "figure12.png",
            caption="../report/figure.rst",
            category="2 Figures",
            labels={
                "item": "Figure 12",
                "shows": "steps per episode on the last task",
            },
        ),
        twins=multiext(FIGURES + "figure12", ".svg", ".csv"),
    log:
        "logs/" + RESULTS + "/figures/figure12.log",
    conda:
        "../envs/ptl.yaml"
    params:
        maps=map_options(),
        tasks=last_task_options(),
        titles=map_titles(),
        methods=curve_methods(),
        confidence=CONFIDENCE,
        colours=method_colours(),
        code=drawing_code("curves"),
    message:
        "Drawing learning curves"
    shell:
        PTL
        + " figure curves {input.steps:q} {params.maps} {params.tasks} {params.titles} {params.methods}"
        " --confidence {params.confidence} --output {output.png:q} 2> {log:q}"


rule draw_measures:
    input:
        steps=rules.measure.output.steps,
        map=config["environments"][MEASURES_SHOWN_IN]["map"],
    output:
        png=report(
            FIGURES + "figure13.png",
            caption="../report/figure.rst",
            category="2 Figures",
            labels={
                "item": "Figure 13",
                "shows": "the measures of transfer on real curves",
            },
        ),
        twins=multiext(FIGURES + "figure13", ".svg", ".csv"),
    log:
        "logs/" + RESULTS + "/figures/figure13.log",
    conda:
        "../envs/ptl.yaml"
    params:
        map=f"{MEASURES_SHOWN_IN}={config['environments'][MEASURES_SHOWN_IN]['map']}",
        task=LAST_TASK[MEASURES_SHOWN_IN],
        title=title_of(MEASURES_SHOWN_IN),
        window=config["measures"]["window"],
        threshold_factor=config["measures"]["threshold_factor"],
        colours=method_colours(),
        code=drawing_code("measures"),
    message:
        "Drawing what the measures are"
    shell:
        PTL
        + " figure measures {input.steps:q} --map {params.map:q} --task {params.task} --title {params.title:q}"
        " --window {params.window} --threshold-factor {params.threshold_factor} --output {output.png:q} 2> {log:q}"


rule draw_growth:
    input:
        rules.collect_growth.output,
    output:
        png=report(
            FIGURES + "figure14.png",
            caption="../report/figure.rst",
            category="2 Figures",
            labels={"item": "Figure 14", "shows": "growth of the skill library"},
        ),
        twins=multiext(FIGURES + "figure14", ".svg", ".csv"),
    log:
        "logs/" + RESULTS + "/figures/figure14.log",
    conda:
        "../envs/ptl.yaml"
    params:
        bend=config["growth"]["breakpoint"],
        colours=method_colours(),
        confidence=CONFIDENCE,
        code=drawing_code("growth"),
    message:
        "Drawing the growth of the library"
    shell:
        PTL
        + " figure growth {input:q} --breakpoint {params.bend} --confidence {params.confidence}"
        " --output {output.png:q} 2> {log:q}"


rule draw_library_cost:
    input:
        selection=rules.library_cost.output.selection,
        storage=rules.library_cost.output.storage,
    output:
        png=report(
            FIGURES + "library_cost.png",
            caption="../report/figure.rst",
            category="2 Figures",
            labels={
                "item": "Complexity",
                "shows": "time of a selection and bytes of a library",
            },
        ),
        twins=multiext(FIGURES + "library_cost", ".svg", ".csv"),
    log:
        "logs/" + RESULTS + "/figures/library_cost.log",
    conda:
        "../envs/ptl.yaml"
    params:
        code=drawing_code("library_cost"),
    message:
        "Drawing what a library costs"
    shell:
        PTL
        + " figure library-cost {input.selection:q} {input.storage:q} --output {output.png:q} 2> {log:q}"


rule figures:
    input:
        expand(
            FIGURES + "{figure}.png",
            figure=[
                "figure03",
                *(["figure04"] if "ptl" in METHODS else []),
                *MAP_FIGURES,
                "figure08",
                *(DISCOVERY_FIGURES if "ptl" in METHODS else []),
                "figure12",
                *(["figure13"] if {"ptl", "no_transfer"} <= set(METHODS) else []),
                "figure14",
                "library_cost",
            ],
        ),
