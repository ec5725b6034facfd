"""Remedies for error messages: the command that makes a product of the workflow."""

from __future__ import annotations

import os
import re
import shlex
from contextlib import suppress
from pathlib import Path

from ptl.files.regular import NotReadable, read_bytes

MOST_BYTES = 2**20
"""Most bytes of a configuration file."""

BEYOND = "beyond"
"""Name of the second study, which is a workflow of its own; its configuration files begin with it."""

APART = ("robustness", "fit")
"""Folders of what is made only if it is asked for by this name."""

FOREIGN = "it belongs to no run of this folder, so name another file or make it again where it came from"
"""Remedy for a file that the workflow in this folder does not make."""


def rebuild_command(path: str | os.PathLike[str]) -> str:
    """Return the Snakemake command that makes this product, with the configuration file that names its run."""
    return f"snakemake {shlex.quote(str(_inside(path)))} --cores 1{_chosen(path)}"


def _chosen(path: str | os.PathLike[str]) -> str:
    """Return the option that names the configuration file, empty for the one that the Snakefile names."""
    config = _config_of(path)
    if config is not None and config.stem.startswith(BEYOND):
        base = f"config/{BEYOND}.yaml"
        return f" --snakefile workflow/{BEYOND}.smk --configfile {' '.join(dict.fromkeys((base, str(config))))}"
    return "" if config is None or config.name == "config.yaml" else f" --configfile {shlex.quote(str(config))}"


def is_product(path: str | os.PathLike[str]) -> bool:
    """Return whether a path is one of a product of a run that a configuration file in this folder names."""
    return _config_of(path) is not None


def _inside(path: str | os.PathLike[str]) -> Path:
    """Return a path relative to this folder; one outside of it stays as it is."""
    product = Path(os.path.relpath(path))
    return Path(path) if product.parts[:1] == ("..",) else product


def _config_of(path: str | os.PathLike[str]) -> Path | None:
    """Return the configuration file of the run that a product belongs to."""
    place, *names = _inside(path).parts or ("",)
    if place not in {"results", "reports"} or len(names) < 2:
        return None
    for config in (*sorted(Path("config").glob("*.yaml")), *sorted(Path().glob("*.yaml"))):
        with suppress(NotReadable):
            text = read_bytes(config, MOST_BYTES).decode("utf-8", "replace")
            named = re.search(r"^run:[ \t]*[\"']?([\w-]+)", text, flags=re.M)
            if named and named[1] == names[0]:
                return config
    return None


def make_again(path: str | os.PathLike[str], product: str | os.PathLike[str] | None = None) -> str:
    """Return the remedy for a file that exists but cannot be used.

    Parameters
    ----------
    product : path, optional
        What to ask of the workflow instead of the file itself.
    """
    if not is_product(path):
        return FOREIGN
    return f"remove it and run '{rebuild_command(product or path)}' to make it again"


def force(path: str | os.PathLike[str], *rules: str) -> str:
    """Return the remedy for files that rules made for another question, though Snakemake takes them for right.

    Without rules, everything is made again.
    """
    if not is_product(path):
        return FOREIGN
    forced = f"--forcerun {' '.join(rules)}" if rules else "--forceall"
    study = _inside(path).parts[2]
    target = f" {study}" if study in APART else ""
    return f"run 'snakemake{target} --cores 1{_chosen(path)} {forced}' to make it and all like it again"


def make(path: str | os.PathLike[str]) -> str:
    """Return the remedy for a file that is missing."""
    return f"run '{rebuild_command(path)}' to make it" if is_product(path) else "check the path"
