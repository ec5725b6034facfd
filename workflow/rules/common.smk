# Names, checks and parameters that all rules share: the configuration, the maps, and every job by the place of its file.

import json
import os
import sys
from pathlib import Path

from ptl import methods
from ptl.claims.decision import decision_jobs, goes_on
from ptl.cli.forks import shell_prefix
from ptl.errors import UserError
from ptl.files import aging
from ptl.files.checkout import check_workflow
from ptl.files.configuration import completed, read_yaml
from ptl.files.foreign import seeds_of
from ptl.files.job import packed
from ptl.files.provenance import check_build, code_digest
from ptl.files.regular import below, refuse_other, sha256
from ptl.jobs import planned
from ptl.learning.trial import colour_notes
from ptl.measures.cost import FLAG, check_cost, cost_of
from ptl.report.figures import left_out
from ptl.world.gridworld import map_digest
from ptl.world.map_files import read_map


def refuse(error):
    """Ends the run with one line instead of a traceback."""
    print(f"error: {error}", file=sys.stderr, flush=True)
    os._exit(1)


def prefixed(path):
    """Path with the prefix that a module which uses these rules may give to all their files."""
    return workflow.modifier.path_modifier.replace_prefix(str(path))


try:
    check_workflow(workflow.current_basedir)
    if workflow.modifier.path_modifier.modifies_prefixes:
        raise UserError("replace_prefix: is not supported; give the module a prefix")
    check_build()
    for path in workflow.configfiles:
        read_yaml(path)  # refuses repeated keys, of which Snakemake keeps the last
    RUN = completed(config)
    config.update(RUN.to_dict())
    MAPS = {name: entry["map"] for name, entry in config["environments"].items()}
    if RUN.article:
        MAPS[planned.MISLEADING] = planned.MISLEADING_ENTRY.map
    OPTIONS = {name: entry.map_options for name, entry in RUN.environments.items()}
    READ = {name: read_map(path, OPTIONS.get(name)) for name, path in MAPS.items()}
    WORLDS = {name: read.world for name, read in READ.items()}
    DIGESTS = {name: map_digest(world.text) for name, world in WORLDS.items()}
    COST = cost_of(RUN, WORLDS)
    check_cost(COST, allowed=bool(os.environ.get(FLAG)))
    if workflow.is_main_process:
        refuse_other(*below(Path(prefixed(f"logs/{config['run']}"))))
    LEARNING = planned.learning_jobs(RUN, DIGESTS)
    MISLEADING = planned.misleading_jobs(RUN, DIGESTS)
    GROWTH = planned.growth_jobs(RUN, DIGESTS)
    SURVEYS = planned.survey_jobs(RUN, DIGESTS)
    BATCHES = {
        part.place: part
        for survey in SURVEYS.values()
        for part in survey.parts(RUN.subgoal_frequencies.batches)
    }
    DECISION = decision_jobs(RUN, DIGESTS) if RUN.article else {}
except UserError as error:
    refuse(error)

shell.prefix(shell_prefix())

JOBS = {**LEARNING, **MISLEADING, **GROWTH, **SURVEYS, **BATCHES, **DECISION}
LAST_LOOK = len(RUN.decision.looks)
ENVIRONMENTS = list(config["environments"])
REFERENCES = methods.by_identifier(config["methods"])
METHODS = list(REFERENCES)
BUILT_IN = [name for name in METHODS if REFERENCES[name] == name]
FOREIGN = config["foreign_results"]
FOREIGN_DIGESTS = {name: sha256(entry["file"]) for name, entry in FOREIGN.items()}
ARTICLE = RUN.article
SECTIONS = (
    ["Verdicts", "Figures", "Tables", "Explorer"]
    if ARTICLE
    else ["Figures", "Tables", "Explorer"]
)
# a function that is called later has no modifier any more
PLACE = Path(prefixed(f"results/{config['run']}"))
RESULTS, REPORTS = Path("results", config["run"]), Path("reports", config["run"])


if workflow.is_main_process:
    aging.age_results(PLACE, [*JOBS.values()])
    uncounted = (
        "" if len(BUILT_IN) == len(METHODS) else "; methods of your own may take more"
    )
    print(
        f"a whole run takes about {COST}, without drawing{uncounted}", file=sys.stderr
    )
    map_notes = [note for read in READ.values() for note in read.notes]
    for note in [*map_notes, *colour_notes(config["methods"])]:
        print(f"note: {note}", file=sys.stderr)
    for name, entry in RUN.foreign_results.items():
        if numbers := seeds_of(entry.file, name, RUN.seeds):
            shown = ", ".join(f"{seed} is {place}" for seed, place in numbers.items())
            print(
                f"note: {entry.file}: seeds of {name} are numbered: {shown}",
                file=sys.stderr,
            )
    for figure, missing in left_out(config, ARTICLE).items():
        print(
            f"{figure} is left out: it shows {missing}, which methods does not name",
            file=sys.stderr,
        )


pathvars:
    results=str(RESULTS),
    reports=str(REPORTS),
    logs=f"logs/{config['run']}",


wildcard_constraints:
    environment="[a-z][a-z0-9_]*",
    method="[a-z][a-z0-9_]*",
    seed="[0-9]+",
    run="[0-9]+",
    batch="[0-9]+",


def job_of(wildcards, output):
    """Job that makes a result file, as JSON."""
    return job_at(output[0]).text


def maps_of(wildcards, output):
    """Maps of that job for its command line, with what their files leave open."""
    names = list(job_at(output[0]).maps)
    options = {name: OPTIONS[name].to_dict() for name in names if name in OPTIONS}
    return [f"--map={name}={MAPS[name]}" for name in names] + [
        f"--map-options={name}={json.dumps(given)}"
        for name, given in options.items()
        if given
    ]


def job_at(path):
    """Job that makes the result file at this path."""
    return JOBS[Path(path).relative_to(PLACE).as_posix()]


def map_files(names=ENVIRONMENTS):
    """Map files of environments; a prefix of the module is for what is made."""
    return [local(MAPS[name]) for name in names]


def files_of(jobs):
    """Paths of the files of jobs."""
    return [str(RESULTS / place) for place in jobs]


def decided(look):
    """Files of the runs that decide claims: those of the first look, and of later ones while a claim is open."""
    chosen = [job for job in DECISION.values() if job.look == 1]
    # a run without what claims speak of has no looks
    for before in range(1, look if chosen else 1):
        found = checkpoints.look.get(look=before).output.open
        pairs = {
            tuple(pair)
            for pair in json.loads(Path(found).read_text(encoding="utf-8"))["open"]
        }
        chosen += [
            job
            for job in DECISION.values()
            if job.look == before + 1 and goes_on(job, pairs)
        ]
        if not pairs:
            break
    return files_of(job.place for job in chosen)


def learning_of(environments=ENVIRONMENTS, methods=METHODS, seeds=None):
    """Learning jobs of some environments, methods and numbers of seeds, in the order of the tables."""
    return {
        place: job
        for place, job in LEARNING.items()
        if job.environment in environments
        and job.method in methods
        and (seeds is None or job.seed < seeds)
    }


def map_digests(names=ENVIRONMENTS):
    """Digests of maps, for rules that read them: time stamps do not tell that a map was replaced by an older file."""
    return {name: DIGESTS[name] for name in names}


def section(name):
    """Section of the report; Snakemake shows them in alphabetical order."""
    return f"{SECTIONS.index(name) + 1} {name}"


def groups(*names):
    """Groups of the configuration for a job, whole."""
    return {name: config[name] for name in names}


def entries(names=ENVIRONMENTS):
    """Entries of the configuration for some environments, in the order given."""
    return {name: config["environments"][name] for name in names}


def method_modules(names):
    """Modules that define methods of the package."""
    return [f"ptl.methods.{name}" for name in names if name in BUILT_IN]


def looks(names=METHODS):
    """Label and colour of methods."""
    kinds = {name: methods.load(REFERENCES[name]) for name in names}
    return {name: [kind.label, kind.colour] for name, kind in kinds.items()}


def batches_of(environment):
    """Jobs of the batches of an environment."""
    return [part for part in BATCHES.values() if part.environment == environment]


def results_of(row):
    """Jobs whose files a figure shows, by kind of input."""
    jobs = {
        "learning": learning_of(row.environments, row.methods),
        "misleading_prior": MISLEADING,
        "survey": {
            place: job
            for place, job in SURVEYS.items()
            if job.environment in row.environments
        },
    }
    return {kind: jobs[kind] for kind in row.needs if kind in jobs}


def sources_of(row):
    """Input files of a figure by kind, as its row asks for them."""
    files = {
        "maps": map_files(row.environments),
        "per_seed": rules.measure.output.per_seed,
        "steps": rules.measure.output.steps,
        "growth": rules.collect_growth.output[0],
        "selection_cost": rules.library_cost.output.selection,
        "library_bytes": rules.library_cost.output.storage,
    }
    files |= {kind: files_of(jobs) for kind, jobs in results_of(row).items()}
    if ARTICLE:
        files["claims"] = rules.judge_claims.output.csv
    return {kind: files[kind] for kind in row.needs}


def result_jobs(row):
    """All jobs whose files a figure shows."""
    return [job for jobs in results_of(row).values() for job in jobs.values()]
