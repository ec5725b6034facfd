"""The command line ``ptl``: find the subcommand's file, run it and turn user errors into one line."""

from __future__ import annotations

import gc
import sys
from importlib import import_module
from pathlib import Path

import click

import ptl
from ptl.errors import UserError


class _Commands(click.Group):
    """Loads only the subcommand that is called, so that a job pays for no other's imports."""

    def list_commands(self, context: click.Context) -> list[str]:
        folder = Path(__file__).parent
        return sorted(path.stem.replace("_", "-") for path in folder.glob("[!_]*.py"))

    def get_command(self, context: click.Context, name: str) -> click.Command | None:
        if name not in self.list_commands(context):
            return None
        return import_module(f"ptl.cli.{name.replace('-', '_')}").command


@click.command(cls=_Commands, context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110})
@click.version_option(ptl.__version__, prog_name="ptl")
def commands() -> None:
    """Partial transfer learning with a skill library: run, inspect and verify single parts of the reproduction."""


def main() -> None:
    """Run the command line; exit status 0 on success, 1 with one line on stderr on an error that the user can mend."""
    try:
        _refuse_copied_environment(Path(sys.argv[0]).parent.parent)
        commands()
    except UserError as error:
        sys.exit(f"error: {error}")
    finally:
        # All that is alive now dies with the process. Looking through it for garbage takes a tenth of a learning job.
        gc.freeze()


def _refuse_copied_environment(folder: Path) -> None:
    """Refuse a copy of ``bin/ptl``, whose first line still names the environment, and so the code, of the original."""
    if (folder / "pyvenv.cfg").exists() and not folder.samefile(sys.prefix):
        raise UserError(
            f"{folder}: was copied, and its commands run the code of {sys.prefix}; run 'make build' beside it"
        )


if __name__ == "__main__":
    main()
