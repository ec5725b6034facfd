"""Remedies for error messages: the command that makes a product of the workflow."""

from __future__ import annotations

import os
import re
import shlex
from pathlib import Path


def rebuild_command(path: str | os.PathLike[str]) -> str:
    """Return the Snakemake command that makes this product, with the configuration file that names its run.

    Called in the folder of the Snakefile; a product outside of it is named as it is.
    """
    product = Path(os.path.relpath(path)) if Path(path).is_absolute() else Path(path)
    if product.parts[:1] == ("..",):
        product = Path(path)
    command = f"snakemake {shlex.quote(str(product))} --cores 1"
    if product.parts[:1] in {("results",), ("reports",)} and len(product.parts) > 1:
        for config in sorted(Path("config").glob("*.yaml")):
            named = re.search(r"^run:[ \t]*[\"']?([\w-]+)", config.read_text(encoding="utf-8"), flags=re.M)
            if named and named[1] == product.parts[1]:
                chosen = "" if config.name == "config.yaml" else f" --configfile {shlex.quote(str(config))}"
                return command + chosen
    return command


def make_again(path: str | os.PathLike[str]) -> str:
    """Return the remedy for a product that exists but cannot be used."""
    return f"remove it and run '{rebuild_command(path)}' to make it again"
