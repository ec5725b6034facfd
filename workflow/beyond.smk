# The second study: methods beyond the article's comparison, on maps that nobody chose.
#
#   maps -> lives (HDF5) -> a row for each life -> estimates, figures, tables, page -> manifest
#
# A workflow of its own, apart from the reproduction: `make beyond` runs it.

import json
import os
import shlex
import sys
from pathlib import Path

from snakemake.utils import min_version

from ptl.errors import UserError
from ptl.files.checkout import check_checkout
from ptl.files.configuration import read_yaml
from ptl.files.lock import begin_run
from ptl.files.outside import learning_code
from ptl.files.provenance import check_build, code_digest
from ptl.files.question import digest_of
from ptl.files.records import codes_of
from ptl.files.regular import below, refuse_other, sha256
from ptl.files.schema import LEARNING, LIVES
from ptl.methods import identifier
from ptl.methods.beyond import reference
from ptl.study.cost import FLAG, check_cost, cost_of_lives
from ptl.study.population import design

min_version("9.27")


# a study of one's own uses this file as a module and has its own configuration
if "methods" not in config:

    configfile: "config/beyond.yaml"


try:
    check_checkout(workflow.current_basedir)
    check_build()
    for path in workflow.configfiles:
        read_yaml(path)  # refuses repeated keys, of which Snakemake keeps the last
    STUDY = design.Study.read(config)
    ENTRIES = design.entries_of(STUDY)
    WORLDS = design.given_worlds(STUDY)
    DIGESTS = design.map_digests(STUDY, ENTRIES, WORLDS)
    CELLS = {cell.name: cell for cell in design.cells(STUDY)}
    JOBS = {
        name: design.job_of(cell, STUDY, DIGESTS[name]) for name, cell in CELLS.items()
    }
    LIVED = ()
    if STUDY.foreign_lives:
        from ptl.study.population.collect import foreign_lives

        LIVED = set(foreign_lives(STUDY)["family"])
    COST = cost_of_lives(JOBS.values(), ENTRIES, WORLDS)
    check_cost(COST, allowed=bool(os.environ.get(FLAG)))
    if workflow.is_main_process:
        refuse_other(*below(Path("logs", STUDY.run)))
except UserError as error:
    print(f"error: {error}", file=sys.stderr, flush=True)
    os._exit(1)

if workflow.is_main_process:
    print(f"the study takes about {COST}", file=sys.stderr)

CODES = {name: design.method_digest(name) for name in STUDY.methods}
FOREIGN_DIGESTS = {path: sha256(path) for path in STUDY.foreign_lives}
QUESTION = design.question_of(STUDY, DIGESTS, CODES)
SHOWN = {identifier(name): name for name in map(reference, STUDY.explorer.methods)}
LEARNED = expand("<results>/lives/{cell}.h5", cell=CELLS)


shell.prefix(
    "set -euo pipefail; export OPENBLAS_NUM_THREADS=1 OMP_NUM_THREADS=1 MPLBACKEND=Agg; "
    f'ptl() {{{{ {shlex.quote(sys.executable)} -m ptl "$@"; }}}}; '
)


pathvars:
    results=f"results/{STUDY.run}",
    reports=f"reports/{STUDY.run}",
    logs=f"logs/{STUDY.run}",


onstart:
    begin_run(f"results/{STUDY.run}", f"reports/{STUDY.run}")


localrules:
    beyond,
    lives,


rule beyond:
    default_target: True
    # the lives come first: the products are tracked, and asking for them alone would be content with what is there
    input:
        LEARNED,
        lambda wildcards: [*rules.check_study.output, *rules.check_study.input],


rule lives:
    input:
        LEARNED,


rule learn_lives:
    input:
        lambda wildcards: (
            STUDY.population
            if CELLS[wildcards.cell].size
            else CELLS[wildcards.cell].maps
        ),
    output:
        "<results>/lives/{cell}.h5",
    log:
        "<logs>/lives/{cell}.log",
    wildcard_constraints:
        cell="[a-zA-Z0-9_/.-]+",
    conda:
        "envs/ptl.yaml"
    params:
        job=lambda wildcards: json.dumps(JOBS[wildcards.cell], sort_keys=True),
        code=lambda wildcards: CODES[CELLS[wildcards.cell].method],
    message:
        "Learning the lives {wildcards.cell}"
    shell:
        "ptl lives --job {params.job:q} --code {params.code} --output {output:q} 2> {log:q}"


rule collect_lives:
    input:
        LEARNED,
    output:
        lives="<reports>/per_life.csv",
        tasks="<results>/per_task.csv",
    log:
        "<logs>/collect_lives.log",
    conda:
        "envs/ptl.yaml"
    params:
        asked={LIVES: QUESTION[LIVES]},
        code=code_digest("ptl.study.population.collect"),
    message:
        "Collecting all lives"
    script:
        "scripts/collect_lives.py"


rule report_beyond:
    input:
        lives=rules.collect_lives.output.lives,
        tasks=rules.collect_lives.output.tasks,
        foreign=STUDY.foreign_lives,
        population=STUDY.population,
    output:
        page="<reports>/index.html",
        parts=expand("<reports>/{file}", file=design.report_files(STUDY, LIVED)),
    log:
        "<logs>/report_beyond.log",
    conda:
        "envs/ptl.yaml"
    params:
        study=STUDY.to_dict(),
        foreign_digests=FOREIGN_DIGESTS,
        code=code_digest(
            "ptl.report.beyond",
            "ptl.report.figures.beyond",
            *STUDY.modules,
        ),
    message:
        "Writing the page of the second study"
    script:
        "scripts/report_beyond.py"


# One life of a few methods on some maps, to watch.


rule write_maps:
    input:
        STUDY.population,
    output:
        directory("<results>/maps"),
    log:
        "<logs>/write_maps.log",
    conda:
        "envs/ptl.yaml"
    params:
        band=STUDY.band,
        size=STUDY.size,
    message:
        "Writing the maps as text"
    shell:
        "ptl population {input:q} --maps {output:q} --band {params.band} --size {params.size} 2> {log:q}"


rule learn:
    input:
        rules.write_maps.output,
    output:
        "<results>/learning/{map}/{method}/seed_000.h5",
    log:
        "<logs>/learning/{map}/{method}.log",
    conda:
        "envs/ptl.yaml"
    params:
        root_seed=STUDY.root_seed,
        parameters=json.dumps(STUDY.parameters, sort_keys=True),
        method=lambda wildcards: SHOWN[wildcards.method],
        code=lambda wildcards: learning_code(SHOWN[wildcards.method]),
    message:
        "Learning {wildcards.map} with {wildcards.method} for the explorer"
    shell:
        "ptl learn --map {input:q}/{wildcards.map}.txt --environment {wildcards.map} --method {params.method:q}"
        " --root-seed {params.root_seed} --parameters {params.parameters:q} --output {output:q} 2> {log:q}"


rule explore_lives:
    input:
        expand(
            "<results>/learning/{map}/{method}/seed_000.h5",
            map=design.shown(STUDY),
            method=SHOWN,
        ),
    output:
        "<reports>/explorer.html",
    log:
        "<logs>/explore_lives.log",
    conda:
        "envs/ptl.yaml"
    params:
        asked={LEARNING: QUESTION[LEARNING]},
        study=STUDY.to_dict(),
        code=code_digest(
            "ptl.report.explorer.data",
            "ptl.report.explorer.page",
            *STUDY.modules,
        ),
    message:
        "Building the explorer of some lives"
    script:
        "scripts/explore_lives.py"


rule check_study:
    input:
        rules.collect_lives.output.lives,
        rules.report_beyond.output,
        rules.explore_lives.output if SHOWN else [],
    output:
        manifest="<reports>/manifest.json",
        # tells products that were made here from those that were checked out
        made="<results>/made.json",
        # is missing as long as no manifest was written for this configuration, these maps and this code
        checked=f"<results>/checked/{digest_of(STUDY.to_dict(), QUESTION, codes_of(workflow.rules), FOREIGN_DIGESTS)}",
    log:
        "<logs>/check_study.log",
    conda:
        "envs/ptl.yaml"
    params:
        config=json.dumps(STUDY.to_dict()),
        maps=DIGESTS,
        asked=QUESTION,
        codes=codes_of(workflow.rules),
        code=code_digest("ptl.files.manifest", "ptl.files.records"),
    message:
        "Holding all products against the study"
    script:
        "scripts/manifest.py"
