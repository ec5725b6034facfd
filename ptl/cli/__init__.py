"""The command line ``ptl``: find the subcommand's file, run it and turn user errors into one line."""

from __future__ import annotations

import codecs
import gc
import io
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import click

import ptl
from ptl.errors import INTERRUPTED, UserError, printable
from ptl.extensions import EXTENSIONS
from ptl.files.checkout import check_checkout

if None in map(find_spec, EXTENSIONS):  # before a command or the workflow imports one
    sys.exit("error: ptl is not built; run 'make build'")

COMMANDS = (
    "new-study", "show-map", "make-map", "import-runs", "learn", "inspect", "metrics", "score", "verify", "workflow",
)  # fmt: skip
"""Commands for users, in the order of the help."""

UPKEEP = ("docs",)
"""Commands that keep the files of this package up to date."""


class _Commands(click.Group):
    """Load only the subcommand that is called, so that a job skips the imports of the others."""

    def list_commands(self, context: click.Context) -> list[str]:
        folder = Path(__file__).parent
        return sorted(path.stem.replace("_", "-") for path in folder.glob("[!_]*.py"))

    def get_command(self, context: click.Context, name: str) -> click.Command | None:
        if name not in self.list_commands(context):
            return None
        return import_module(f"ptl.cli.{name.replace('-', '_')}").command

    def format_commands(self, context: click.Context, formatter: click.HelpFormatter) -> None:
        jobs = [name for name in self.list_commands(context) if name not in (*COMMANDS, *UPKEEP)]
        for title, names in (("Commands", COMMANDS), ("Jobs of the workflow", jobs), ("Upkeep of the package", UPKEEP)):
            with formatter.section(title):
                formatter.write_dl([(name, self._summary(context, name)) for name in names])

    def _summary(self, context: click.Context, name: str) -> str:
        command = self.get_command(context, name)
        assert command is not None
        return command.get_short_help_str(limit=200)

    def make_context(self, *arguments: Any, **extra: Any) -> click.Context:
        with _in_one_line():
            return super().make_context(*arguments, **extra)

    def invoke(self, context: click.Context) -> object:
        with _in_one_line():
            try:
                return super().invoke(context)
            except KeyboardInterrupt:
                raise UserError(INTERRUPTED) from None


@contextmanager
def _in_one_line() -> Iterator[None]:
    """Turn click's messages about wrong arguments into one line."""
    try:
        yield
    except click.exceptions.NoArgsIsHelpError:  # no mistake: the help is shown
        raise
    except click.UsageError as error:
        path = error.ctx.command_path if error.ctx else "ptl"
        raise UserError(f"{path}: {error.format_message().rstrip('.')} (see '{path} --help')") from error


@click.command(cls=_Commands, context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110})
@click.version_option(ptl.__version__, prog_name="ptl")
def commands() -> None:
    """Partial transfer learning with a skill library: run, inspect and verify single parts of the reproduction."""


PLAIN = {"−": "-", "–": "-", "×": "x", "±": "+-", "∞": "inf", "…": "...", "≤": "<=", "≥": ">="}
"""What is printed in place of a letter that the terminal's encoding lacks; other letters are printed as escapes."""


def _plain(error: UnicodeError) -> tuple[str, int]:
    """Replace letters that an encoding lacks (a handler of `codecs`)."""
    assert isinstance(error, UnicodeEncodeError)
    letters = error.object[error.start : error.end]
    shown = (PLAIN.get(letter) or letter.encode("ascii", "backslashreplace").decode() for letter in letters)
    return "".join(shown), error.end


def _tolerate_terminals() -> None:
    """Let a terminal that is not UTF-8 (ISO-8859-1, cp1252) get all numbers."""
    codecs.register_error("ptl_plain", _plain)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper) and codecs.lookup(stream.encoding).name != "utf-8":
            stream.reconfigure(errors="ptl_plain")


def main() -> None:
    """Run the command line; exit status 0 on success, 1 with one line on stderr on an error that the user can mend."""
    _tolerate_terminals()
    try:
        environment = Path(sys.argv[0]).parent.parent
        if (environment / "pyvenv.cfg").exists():  # copied, its scripts name the Python of the original
            check_checkout(environment)
        commands(prog_name="ptl")
    except UserError as error:
        sys.exit(f"error: {error}")
    except MemoryError:
        sys.exit("error: there is not enough memory; raise the limit (ulimit -v) or take a smaller map")
    except OSError as error:
        if error.filename is not None:
            raise
        if isinstance(error, FileNotFoundError):
            sys.exit("error: the present folder has been removed; change to another one")
        sys.exit(f"error: the output cannot be written ({error.strerror})")
    except UnicodeEncodeError:
        sys.exit(f"error: {printable(' '.join(sys.argv[1:]))}: is not UTF-8 text")
    finally:
        # All that is alive now dies with the process. Looking through it for garbage takes a tenth of a learning job.
        gc.freeze()


if __name__ == "__main__":
    main()
