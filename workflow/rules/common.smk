# Names, checks and parameters that all rules share.

import json
import os
import shlex
import sys
from pathlib import Path

from ptl import methods
from ptl.errors import UserError
from ptl.files.checkout import check_checkout
from ptl.files.configuration import completed, read_yaml
from ptl.files.outside import learning_code
from ptl.files.provenance import check_build, code_digest
from ptl.files.question import SIDE_MAPS, about, digest_of, question_of
from ptl.files.records import codes_of
from ptl.files.regular import below, refuse_other, sha256
from ptl.report.figures import left_out
from ptl.report.snakemake_report import keep_checksum
from ptl.study.cost import FLAG, check_cost, cost_of
from ptl.world.gridworld import load_map, map_digest


def refuse(error):
    """Ends the run with one line instead of a traceback."""
    print(f"error: {error}", file=sys.stderr, flush=True)
    os._exit(1)


try:
    check_checkout(Path(workflow.current_basedir).parent)
    check_build()
    for path in workflow.configfiles:
        read_yaml(path)  # refuses repeated keys, of which Snakemake keeps the last
    CONFIGURATION = completed(config)
    config.update(CONFIGURATION.to_dict())
    MAPS = {name: entry["map"] for name, entry in config["environments"].items()}
    MAPS.update(SIDE_MAPS if CONFIGURATION.article else {})
    WORLDS = {name: load_map(path) for name, path in MAPS.items()}
    DIGESTS = {name: map_digest(world.text) for name, world in WORLDS.items()}
    COST = cost_of(CONFIGURATION, WORLDS)
    check_cost(COST, allowed=bool(os.environ.get(FLAG)))
    if workflow.is_main_process:
        refuse_other(*below(Path("logs", config["run"])))
except UserError as error:
    refuse(error)

if any(argument.startswith("--report") for argument in sys.argv):
    keep_checksum(refuse)

# Every job calls the `ptl` of the Python that runs Snakemake, whatever is on the path. Jobs are single-threaded;
# without the settings each one starts a pool of idle threads.
shell.prefix(
    "set -euo pipefail; export OPENBLAS_NUM_THREADS=1 OMP_NUM_THREADS=1 MPLBACKEND=Agg; "
    f'ptl() {{{{ {shlex.quote(sys.executable)} -m ptl "$@"; }}}}; '
)

ENVIRONMENTS = list(config["environments"])
REFERENCES = methods.by_identifier(config["methods"])
METHODS = list(REFERENCES)
CODES = {name: learning_code(reference) for name, reference in REFERENCES.items()}
QUESTION = question_of(config, DIGESTS, CODES)
BUILT_IN = [name for name in METHODS if REFERENCES[name] == name]
# The studies of the article's claims know the package's own methods only.
OWN_CONFIG = {**config, "methods": BUILT_IN, "method_parameters": {}}
FOREIGN = config["foreign_results"]
FOREIGN_DIGESTS = {name: sha256(entry["file"]) for name, entry in FOREIGN.items()}
SEEDS = range(config["seeds"])
ARTICLE = CONFIGURATION.article
SECTIONS = (
    ["Verdicts", "Figures", "Tables", "Explorer", "Checks", "Robustness"]
    if ARTICLE
    else ["Figures", "Tables", "Explorer"]
)


if workflow.is_main_process:
    print(f"a whole run takes about {COST}", file=sys.stderr)
    for figure, missing in left_out(config, ARTICLE).items():
        print(
            f"{figure} is left out: it shows {missing}, which methods does not name",
            file=sys.stderr,
        )


pathvars:
    results=f"results/{config['run']}",
    reports=f"reports/{config['run']}",
    logs=f"logs/{config['run']}",


wildcard_constraints:
    environment="[a-z][a-z0-9_]*",
    method="[a-z][a-z0-9_]*",
    seed="[0-9]+",
    run="[0-9]+",
    batch="[0-9]+",


def map_of(wildcards):
    """Map file of the environment in the wildcards."""
    return config["environments"][wildcards.environment]["map"]


def map_digests(names=ENVIRONMENTS):
    """Digests of maps, for rules that read them: time stamps do not tell that a map was replaced by an older file."""
    return {name: DIGESTS[name] for name in names}


def asked(*kinds, environments=ENVIRONMENTS, methods=None):
    """What files of these kinds must have been made from; whatever reads them checks it."""
    return {kind: about(QUESTION[kind], environments, methods) for kind in kinds}


def section(name):
    """Section of the report; Snakemake shows them in alphabetical order."""
    return f"{SECTIONS.index(name) + 1} {name}"


def groups(*names):
    """Groups of the configuration for a job, whole."""
    return {name: config[name] for name in names}


def hyper_parameters(*names):
    """Groups of the configuration as JSON for a job's command line."""
    return json.dumps(groups(*names), sort_keys=True)


def entries(names=ENVIRONMENTS):
    """Entries of the configuration for some environments, in the order given."""
    return {name: config["environments"][name] for name in names}


def learning_files(environments=ENVIRONMENTS, methods=METHODS):
    """Learning files of the run, in the order of the tables."""
    return expand(
        "<results>/learning/{environment}/{method}/seed_{seed:03d}.h5",
        environment=environments,
        method=methods,
        seed=SEEDS,
    )


def method_modules(names):
    """Modules that define methods of the package."""
    return [f"ptl.methods.{name}" for name in names if name in BUILT_IN]


def looks(names=METHODS):
    """Label and colour of methods."""
    kinds = {name: methods.load(REFERENCES[name]) for name in names}
    return {name: [kind.label, kind.colour] for name, kind in kinds.items()}


def own_parameters(name):
    """Parameters of a method's own that the configuration gives."""
    return config["method_parameters"].get(name, {})


def products_of_study():
    """Checksums of the products of the robustness study by path, if it was made."""
    folder = Path("reports", config["run"], "robustness")
    return {str(path): sha256(path) for path in sorted(folder.glob("*.*"))}


def shares_of_study():
    """Table of the robustness study with its checksum, if the study was made; asking for it would run the study."""
    path = f"reports/{config['run']}/robustness/share.csv"
    return {"path": path, "sha256": sha256(Path(path))} if os.path.isfile(path) else {}
