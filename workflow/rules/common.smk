# Names, checks and parameters that all rules share.

import json
import os
import shlex
import sys

from ptl.configuration import check
from ptl.errors import UserError
from ptl.provenance import check_build, code_digest


def refuse(error):
    """Ends the run with one line instead of a traceback."""
    print(f"error: {error}", file=sys.stderr, flush=True)
    os._exit(1)


try:
    check_build()
    check(config, workflow.source_path("../schemas/config.schema.yaml"))
except UserError as error:
    refuse(error)
validate(config, "../schemas/config.schema.yaml")  # fills in the defaults

# Jobs are single-threaded; without this each one starts a pool of idle threads.
os.environ.update(OPENBLAS_NUM_THREADS="1", OMP_NUM_THREADS="1", MPLBACKEND="Agg")

PTL = f"{shlex.quote(sys.executable)} -m ptl"
RESULTS = f"results/{config['run']}"
REPORTS = f"reports/{config['run']}"
ENVIRONMENTS = list(config["environments"])
METHODS = config["methods"]
SEEDS = range(config["seeds"])


wildcard_constraints:
    environment="[a-z][a-z0-9_]*",
    method="[a-z][a-z0-9_]*",
    seed="[0-9]+",
    run="[0-9]+",
    batch="[0-9]+",


def map_of(wildcards):
    """Map file of the environment in the wildcards."""
    return config["environments"][wildcards.environment]["map"]


def hyper_parameters(*groups):
    """Groups of the configuration as JSON for a job's command line."""
    return json.dumps({group: config[group] for group in groups}, sort_keys=True)


def learning_files(environments=ENVIRONMENTS, methods=METHODS):
    """Learning files of the run, in the order of the tables."""
    return expand(
        RESULTS + "/learning/{environment}/{method}/seed_{seed:03d}.h5",
        environment=environments,
        method=methods,
        seed=SEEDS,
    )


def title_of(environment):
    """Name of an environment in captions and figures."""
    return config["environments"][environment]["title"] or environment


def titles_option():
    """The environments with their titles, in order, as quoted command line options."""
    return " ".join(
        "--environment " + shlex.quote(f"{name}={title_of(name)}")
        for name in ENVIRONMENTS
    )
