# What the robustness study and the fit depend on.

from contextlib import suppress
from functools import cache

from ptl.files.question import asked_jobs
from ptl.files.schema import SETTING
from ptl.measures.cost import cost_of_settings
from studies.robustness.design import GROUPS, jobs_of, read_study

STUDY = config["robustness"]["study"]
SEARCH = "config/fit.yaml"
SEARCH_CODE = code_digest("studies.fit.search", *method_modules(METHODS))


@cache
def study():
    """The study's content, read only when it is asked for."""
    try:
        return read_study(STUDY)
    except UserError as error:
        refuse(error)


@cache
def settings():
    """Jobs of the settings by name."""
    try:
        jobs = jobs_of(study(), OWN_CONFIG)
        cost = cost_of_settings(jobs.values(), WORLDS)
        check_cost(cost, allowed=bool(os.environ.get(FLAG)))
    except UserError as error:
        refuse(error)
    if workflow.is_main_process:
        print(f"the robustness study takes about {cost}", file=sys.stderr)
    return jobs


def settings_of(group):
    """Names of the settings of a group."""
    return [name for name, job in settings().items() if job["group"] == group]


def used_groups():
    """Groups that have settings, in order."""
    return [group for group in GROUPS if settings_of(group)]


def asked_settings(names):
    """What the files of some settings must have been made from."""
    return asked_jobs(
        SETTING, {name: settings()[name] for name in names}, maps=map_digests()
    )


def search_digest():
    """Digest of all that the search depends on; its file is checked when it runs."""
    maps = []
    with suppress(UserError, AttributeError, KeyError, TypeError):
        maps = sorted(map(str, read_yaml(SEARCH)["reference"]["maps"].values()))
    files = {
        path: sha256(Path(path)) for path in (SEARCH, *maps) if os.path.isfile(path)
    }
    return digest_of(files, OWN_CONFIG, SEARCH_CODE)
