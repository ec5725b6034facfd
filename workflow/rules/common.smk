# Names, checks and parameters that all rules share.

import itertools
import json
import os
import shlex
import sys

from ptl.configuration import check, check_text
from ptl.errors import UserError
from ptl.files import remove_unfinished
from ptl.provenance import check_build, code_digest


def refuse(error):
    """Ends the run with one line instead of a traceback."""
    print(f"error: {error}", file=sys.stderr, flush=True)
    os._exit(1)


try:
    check_build()
    for path in workflow.configfiles:
        check_text(path)
    check(config, workflow.source_path("../schemas/config.schema.yaml"))
except UserError as error:
    refuse(error)
validate(config, "../schemas/config.schema.yaml")  # fills in the defaults

# Every job calls the `ptl` of the Python that runs Snakemake, whatever is on the path. Jobs are single-threaded;
# without the settings each one starts a pool of idle threads.
shell.prefix(
    "set -euo pipefail; export OPENBLAS_NUM_THREADS=1 OMP_NUM_THREADS=1 MPLBACKEND=Agg; "
    f'ptl() {{{{ {shlex.quote(sys.executable)} -m ptl "$@"; }}}}; '
)

# The article's environments come first, whatever order the configuration files were merged in.
ENVIRONMENTS = sorted(
    config["environments"],
    key=lambda name: config["environments"][name]["article_items"].get("map", "~"),
)
METHODS = config["methods"]
SEEDS = range(config["seeds"])


pathvars:
    results=f"results/{config['run']}",
    reports=f"reports/{config['run']}",
    logs=f"logs/{config['run']}",


onstart:
    remove_unfinished(f"results/{config['run']}", f"reports/{config['run']}")


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
        "<results>/learning/{environment}/{method}/seed_{seed:03d}.h5",
        environment=environments,
        method=methods,
        seed=SEEDS,
    )


def numbered(pattern, count):
    """Result files with [] for a number, as one range: commands must not grow with the number of seeds."""
    numbers = pattern.replace("[]", f"[0-{count - 1}]")
    return f"results/{config['run']}/{numbers}"


def numbered_learning_files(environments=ENVIRONMENTS, methods=METHODS):
    """Learning files of the run as ranges of seeds, in the order of the tables."""
    return [
        numbered(f"learning/{environment}/{method}/seed_[].h5", config["seeds"])
        for environment in environments
        for method in methods
    ]


def title_of(environment):
    """Name of an environment in captions and figures."""
    return config["environments"][environment]["title"] or environment


def titles_option():
    """The environments with their titles, in order, as quoted command line options."""
    return " ".join(
        shlex.join(["--environment", f"{name}={title_of(name)}"])
        for name in ENVIRONMENTS
    )


CONFIDENCE = config["statistics"]["confidence"]
LAST_TASK = {name: config["environments"][name]["tasks"][-1] for name in ENVIRONMENTS}


def article_item(environment, kind):
    """Name of the figure of an environment: the article's number, or one made from the environment's name."""
    entry = config["environments"][environment]
    return entry["article_items"].get(kind, f"{kind}_{environment}")


def environment_with(kind):
    """The environment that one of the article's figures is drawn for; the last one if the configuration names none."""
    named = [
        name
        for name in ENVIRONMENTS
        if kind in config["environments"][name]["article_items"]
    ]
    return named[0] if named else ENVIRONMENTS[-1]


PRIOR_SHOWN_IN = environment_with("prior")
MEASURES_SHOWN_IN = environment_with("measures")


MAP_FIGURES = {
    article_item(environment, "map"): environment for environment in ENVIRONMENTS
}
DISCOVERY_FIGURES = {
    article_item(environment, "discovery"): environment for environment in ENVIRONMENTS
}


def item_label(figure):
    """What the report calls a figure: its number in the article, or its kind for an environment of one's own."""
    if figure.startswith("figure"):
        return figure.replace("figure", "Figure ")
    return figure.partition("_")[0].capitalize()


def map_titles():
    """The environments' titles as quoted options of the drawing commands."""
    return " ".join(
        shlex.join(["--title", f"{name}={title_of(name)}"]) for name in ENVIRONMENTS
    )


def drawing_code(module):
    """Digest of what one figure is made by."""
    return code_digest("ptl.figures.style", f"ptl.figures.{module}")


def method_colours():
    """Digest of the files that give the methods their names and colours."""
    return code_digest(*[f"ptl.methods.{method}" for method in METHODS])


def map_options():
    """The environments with their maps as quoted options of the drawing commands."""
    maps = {name: config["environments"][name]["map"] for name in ENVIRONMENTS}
    return " ".join(
        shlex.join(["--map", f"{name}={path}"]) for name, path in maps.items()
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
