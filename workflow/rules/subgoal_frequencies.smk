# Subgoals over all pairs of start and goal, in batches of goals.


rule survey_batch:
    input:
        map=map_of,
    output:
        temp("<results>/subgoal_frequencies/{environment}/batch_{batch}.h5"),
    log:
        "<logs>/subgoal_frequencies/{environment}/batch_{batch}.log",
    # The longest jobs of the run go first, so that short ones fill the gap at the end.
    priority: 2
    conda:
        "../envs/ptl.yaml"
    params:
        survey=config["subgoal_frequencies"],
        root_seed=config["root_seed"],
        map=lambda wildcards: DIGESTS[wildcards.environment],
        parameters=hyper_parameters("learning"),
        code=code_digest("ptl.learning.survey", "ptl.files.results"),
    message:
        "Surveying the subgoals of {wildcards.environment}, batch {wildcards.batch} of {params.survey[batches]}"
    shell:
        "ptl survey batch --map {input.map:q} --environment {wildcards.environment} --batch {wildcards.batch}"
        " --batches {params.survey[batches]} --starts {params.survey[starts]}"
        " --trajectories {params.survey[trajectories]}"
        " --root-seed {params.root_seed} --parameters {params.parameters:q} --output {output:q} 2> {log:q}"


rule merge_survey:
    input:
        expand(
            "<results>/subgoal_frequencies/{{environment}}/batch_{batch}.h5",
            batch=range(config["subgoal_frequencies"]["batches"]),
        ),
    output:
        "<results>/subgoal_frequencies/{environment}.h5",
    log:
        "<logs>/subgoal_frequencies/{environment}.log",
    conda:
        "../envs/ptl.yaml"
    params:
        code=code_digest("ptl.learning.survey", "ptl.files.results"),
    message:
        "Adding up the subgoals of {wildcards.environment}"
    shell:
        "ptl survey merge {input:q} --output {output:q} 2> {log:q}"


rule subgoal_frequencies:
    input:
        expand(
            "<results>/subgoal_frequencies/{environment}.h5", environment=ENVIRONMENTS
        ),
