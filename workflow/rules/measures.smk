# From the files of all jobs to one row a seed.


rule measure:
    input:
        learning=files_of(LEARNING),
        foreign=[local(entry["file"]) for entry in FOREIGN.values()],
    output:
        per_seed="<reports>/tables/per_seed.csv",
        subgoals="<reports>/tables/subgoals.csv",
        episodes="<reports>/tables/episodes.csv.gz",
        steps="<results>/steps.h5",
    log:
        "<logs>/measure.log",
    priority: 1
    conda:
        "../envs/ptl.yaml"
    params:
        groups=groups("measures", "learning"),
        jobs=packed(LEARNING.values()),
        environments=entries(),
        maps=map_digests(),
        seeds=config["seeds"],
        foreign=FOREIGN,
        foreign_digests=FOREIGN_DIGESTS,
        code=code_digest("ptl.measures.run_files", "ptl.files.foreign"),
    message:
        "Measuring {config[run]}: jump start, asymptotic performance, threshold, totals, transfer ratio"
    script:
        "../scripts/measure.py"


rule collect_growth:
    input:
        rules.growth.input,
    output:
        "<reports>/tables/growth.csv",
    log:
        "<logs>/collect_growth.log",
    conda:
        "../envs/ptl.yaml"
    params:
        jobs=packed(GROWTH.values()),
        code=code_digest("ptl.measures.run_files"),
    message:
        "Collecting the growth of the library"
    script:
        "../scripts/collect_growth.py"


rule library_cost:
    input:
        maps=map_files(),
    output:
        selection="<reports>/tables/selection_cost.csv",
        storage="<reports>/tables/library_bytes.csv",
    log:
        "<logs>/library_cost.log",
    conda:
        "../envs/ptl.yaml"
    params:
        environments=entries(),
        maps=map_digests(),
        code=code_digest("ptl.measures.library_cost"),
    message:
        "Counting the cost of a skill selection and of a library"
    script:
        "../scripts/library_cost.py"
