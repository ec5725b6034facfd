# Subgoals over all pairs of start and goal, in batches of goals.


rule survey_batch:
    input:
        map=lambda wildcards: map_files([wildcards.environment]),
    output:
        temp("<results>/subgoal_frequencies/{environment}/batch_{batch}.h5"),
    log:
        "<logs>/subgoal_frequencies/{environment}/batch_{batch}.log",
    # The longest jobs of the reproduction go first, so that short ones fill the gap at the end. In a study of one's own
    # the learning curves come first.
    priority: 2 if ARTICLE else -1
    conda:
        "../envs/ptl.yaml"
    params:
        job=job_of,
        maps=maps_of,
    message:
        "Surveying the subgoals of {wildcards.environment}, batch {wildcards.batch}"
    shell:
        "ptl run --job {params.job:q} {params.maps:q} --output {output:q} 2> {log:q}"


rule merge_survey:
    input:
        lambda wildcards: [
            RESULTS / part.place for part in batches_of(wildcards.environment)
        ],
    output:
        "<results>/subgoal_frequencies/{environment}.h5",
    log:
        "<logs>/subgoal_frequencies/{environment}.log",
    conda:
        "../envs/ptl.yaml"
    params:
        jobs=lambda wildcards: packed(batches_of(wildcards.environment)),
    message:
        "Adding up the subgoals of {wildcards.environment}"
    script:
        "../scripts/merge_survey.py"


rule subgoal_frequencies:
    input:
        files_of(SURVEYS),
