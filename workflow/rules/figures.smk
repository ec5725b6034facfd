# The article's figures. Each one is a PNG for reading, an SVG for printing and a CSV of the numbers drawn.


rule draw_prior:
    input:
        map=config["environments"][PRIOR_SHOWN_IN]["map"],
    output:
        png=report(
            "<reports>/figures/figure03.png",
            caption="../report/figure.rst",
            category="2 Figures",
            labels={"item": "Figure 03", "shows": "prior of a skill by where it ends"},
        ),
        twins=multiext("<reports>/figures/figure03", ".svg", ".csv"),
    log:
        "<logs>/figures/figure03.log",
    conda:
        "../envs/ptl.yaml"
    params:
        goal=LAST_TASK[PRIOR_SHOWN_IN],
        title=title_of(PRIOR_SHOWN_IN),
        form=config["skills"]["prior_form"],
        width=config["skills"]["prior_width"],
        code=drawing_code("prior"),
    message:
        "Drawing the prior of a skill"
    shell:
        "ptl figure prior {input.map:q} --goal {params.goal} --form {params.form} --width {params.width}"
        " --title {params.title:q} --output {output.png:q} 2> {log:q}"


rule learn_misleading:
    input:
        map="config/misleading_prior.txt",
    output:
        "<results>/misleading_prior/seed_{seed}.h5",
    log:
        "<logs>/misleading_prior/seed_{seed}.log",
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
        "ptl learn --map {input.map:q} --environment misleading_prior --tasks ABC --method ptl"
        " --seed {params.seed} --root-seed {params.root_seed}"
        " --parameters {params.parameters:q} --output {output:q} 2> {log:q}"


rule draw_misleading_prior:
    input:
        expand("<results>/misleading_prior/seed_{seed:03d}.h5", seed=SEEDS),
    output:
        png=report(
            "<reports>/figures/figure04.png",
            caption="../report/figure.rst",
            category="2 Figures",
            labels={
                "item": "Figure 04",
                "shows": "the likelihood overrules a misleading prior",
            },
        ),
        twins=multiext("<reports>/figures/figure04", ".svg", ".csv"),
    log:
        "<logs>/figures/figure04.log",
    conda:
        "../envs/ptl.yaml"
    params:
        files=numbered("misleading_prior/seed_[].h5", config["seeds"]),
        confidence=CONFIDENCE,
        code=drawing_code("misleading_prior"),
    message:
        "Drawing how the likelihood overrules a misleading prior"
    shell:
        "ptl figure misleading-prior {params.files:q} --confidence {params.confidence} --output {output.png:q} 2> {log:q}"


rule draw_map:
    input:
        map=lambda wildcards: config["environments"][MAP_FIGURES[wildcards.figure]][
            "map"
        ],
    output:
        png=report(
            "<reports>/figures/{figure}.png",
            caption="../report/figure.rst",
            category="2 Figures",
            labels=lambda wildcards: {
                "item": item_label(wildcards.figure),
                "shows": f"map of {title_of(MAP_FIGURES[wildcards.figure])}",
            },
        ),
        twins=multiext("<reports>/figures/{figure}", ".svg", ".csv"),
    log:
        "<logs>/figures/{figure}.log",
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
        "ptl figure map {input.map:q} --title {params.title:q} --output {output.png:q} 2> {log:q}"


rule draw_frequencies:
    input:
        rules.subgoal_frequencies.input,
    output:
        png=report(
            "<reports>/figures/figure08.png",
            caption="../report/figure.rst",
            category="2 Figures",
            labels={"item": "Figure 08", "shows": "subgoal selection frequencies"},
        ),
        twins=multiext("<reports>/figures/figure08", ".svg", ".csv"),
    log:
        "<logs>/figures/figure08.log",
    conda:
        "../envs/ptl.yaml"
    params:
        titles=map_titles(),
        code=drawing_code("frequencies"),
    message:
        "Drawing subgoal selection frequencies"
    shell:
        "ptl figure frequencies {input:q} {params.titles} --output {output.png:q} 2> {log:q}"


rule draw_discovery:
    input:
        lambda wildcards: learning_files([DISCOVERY_FIGURES[wildcards.figure]], ["ptl"]),
    output:
        png=report(
            "<reports>/figures/{figure}.png",
            caption="../report/figure.rst",
            category="2 Figures",
            labels=lambda wildcards: {
                "item": item_label(wildcards.figure),
                "shows": f"subgoal discovery in {title_of(DISCOVERY_FIGURES[wildcards.figure])}",
            },
        ),
        twins=multiext("<reports>/figures/{figure}", ".svg", ".csv"),
    log:
        "<logs>/figures/{figure}.log",
    wildcard_constraints:
        figure="|".join(DISCOVERY_FIGURES),
    conda:
        "../envs/ptl.yaml"
    params:
        files=lambda wildcards: numbered_learning_files(
            [DISCOVERY_FIGURES[wildcards.figure]], ["ptl"]
        ),
        title=lambda wildcards: title_of(DISCOVERY_FIGURES[wildcards.figure]),
        tasks=lambda wildcards: discovery_tasks(DISCOVERY_FIGURES[wildcards.figure]),
        code=drawing_code("discovery"),
    message:
        "Drawing subgoal discovery, {wildcards.figure}"
    shell:
        "ptl figure discovery {params.files:q} --tasks {params.tasks} --title {params.title:q}"
        " --output {output.png:q} 2> {log:q}"


rule draw_curves:
    input:
        steps=rules.measure.output.steps,
        maps=[
            config["environments"][environment]["map"] for environment in ENVIRONMENTS
        ],
    output:
        png=report(
            "<reports>/figures/figure12.png",
            caption="../report/figure.rst",
            category="2 Figures",
            labels={
                "item": "Figure 12",
                "shows": "steps per episode on the last task",
            },
        ),
        twins=multiext("<reports>/figures/figure12", ".svg", ".csv"),
    log:
        "<logs>/figures/figure12.log",
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
        "ptl figure curves {input.steps:q} {params.maps} {params.tasks} {params.titles} {params.methods}"
        " --confidence {params.confidence} --output {output.png:q} 2> {log:q}"


rule draw_measures:
    input:
        steps=rules.measure.output.steps,
        map=config["environments"][MEASURES_SHOWN_IN]["map"],
    output:
        png=report(
            "<reports>/figures/figure13.png",
            caption="../report/figure.rst",
            category="2 Figures",
            labels={
                "item": "Figure 13",
                "shows": "the measures of transfer on real curves",
            },
        ),
        twins=multiext("<reports>/figures/figure13", ".svg", ".csv"),
    log:
        "<logs>/figures/figure13.log",
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
        "ptl figure measures {input.steps:q} --map {params.map:q} --task {params.task} --title {params.title:q}"
        " --window {params.window} --threshold-factor {params.threshold_factor} --output {output.png:q} 2> {log:q}"


rule draw_growth:
    input:
        rules.collect_growth.output,
    output:
        png=report(
            "<reports>/figures/figure14.png",
            caption="../report/figure.rst",
            category="2 Figures",
            labels={"item": "Figure 14", "shows": "growth of the skill library"},
        ),
        twins=multiext("<reports>/figures/figure14", ".svg", ".csv"),
    log:
        "<logs>/figures/figure14.log",
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
        "ptl figure growth {input:q} --breakpoint {params.bend} --confidence {params.confidence}"
        " --output {output.png:q} 2> {log:q}"


rule draw_library_cost:
    input:
        selection=rules.library_cost.output.selection,
        storage=rules.library_cost.output.storage,
    output:
        png=report(
            "<reports>/figures/library_cost.png",
            caption="../report/figure.rst",
            category="2 Figures",
            labels={
                "item": "Complexity",
                "shows": "time of a selection and bytes of a library",
            },
        ),
        twins=multiext("<reports>/figures/library_cost", ".svg", ".csv"),
    log:
        "<logs>/figures/library_cost.log",
    conda:
        "../envs/ptl.yaml"
    params:
        code=drawing_code("library_cost"),
    message:
        "Drawing what a library costs"
    shell:
        "ptl figure library-cost {input.selection:q} {input.storage:q} --output {output.png:q} 2> {log:q}"


rule figures:
    input:
        expand(
            "<reports>/figures/{figure}.{format}",
            format=["png", "svg", "csv"],
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
