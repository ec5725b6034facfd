"""Places of this checkout, and copies of it in which the workflow runs on a tiny configuration."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import yaml

ROOT = next(folder for folder in Path(__file__).resolve().parents if (folder / "Snakefile").is_file())
MAPS = ROOT / "config/environments"
ROOMS = "#########\n#I..#..A#\n#.......#\n#...#..B#\n#########\n"
"""Map ``rooms.txt`` of every copy."""

TINY: dict[str, Any] = {
    "run": "tiny",
    "seeds": 2,
    "environments": {
        "rooms": {"map": "rooms.txt", "title": "Two rooms", "tasks": "AB", "article_items": {"measures": "figure13"}}
    },
    "methods": ["no_transfer", "policy_reuse", "ptl"],
    "learning": {"episodes": 20},
    "statistics": {"resamples": 100},
    "growth": {"environment": "rooms", "tasks": 4, "runs": 2, "breakpoint": 2},
    "subgoal_frequencies": {"trajectories": 3, "starts": 4, "batches": 2},
}
"""Configuration of a copy: every kind of job in a few seconds, those on the article among them."""

TARGETS = (
    "reports/tiny/tables/per_seed.csv",
    "reports/tiny/tables/growth.csv",
    "results/tiny/subgoal_frequencies/rooms.h5",
)
"""Made by jobs of each kind that stores results: learning, growth, survey (with temporary files), measures."""


class Project:
    """A copy of the checkout with the built extensions; groups given as ``changes`` replace those of `TINY`."""

    def __init__(self, folder: Path, config: dict[str, Any] | None = TINY, **changes: Any) -> None:
        self.folder = folder
        for name in ("config", "workflow", "profiles", "ptl"):
            shutil.copytree(ROOT / name, folder / name, ignore=shutil.ignore_patterns("__pycache__", "*.c"))
        shutil.copy(ROOT / "Snakefile", folder)
        (folder / "rooms.txt").write_text(ROOMS)
        if config is not None:
            self.configure({**config, **changes})

    @classmethod
    def copy_of(cls, folder: Path, target: Path) -> Project:
        """Copy the folder of a project with all that was made in it."""
        copy = object.__new__(cls)
        copy.folder = target
        shutil.copytree(folder, target, symlinks=True)
        return copy

    def add_study(self, name: str) -> None:
        """Copy a folder of studies/."""
        target = self.folder / "studies"
        shutil.copytree(ROOT / "studies" / name, target / name, ignore=shutil.ignore_patterns("__pycache__"))
        shutil.copy(ROOT / "studies/__init__.py", target)

    @property
    def config(self) -> dict[str, Any]:
        """The configuration file as it is now."""
        return yaml.safe_load((self.folder / "config/config.yaml").read_text(encoding="utf-8"))

    def configure(self, config: dict[str, Any]) -> None:
        """Write the configuration file."""
        (self.folder / "config/config.yaml").write_text(
            yaml.safe_dump(config, allow_unicode=True, sort_keys=False), encoding="utf-8"
        )

    @property
    def environment(self) -> dict[str, str]:
        """Environment variables under which the copy of the package is imported."""
        # One list of fonts for all: `ptl workflow` would have one made in every folder.
        fonts = os.environ.get("MPLCONFIGDIR", str(Path.home() / ".cache/matplotlib"))
        return os.environ | {"PYTHONPATH": str(self.folder), "MPLCONFIGDIR": fonts}

    def python(self, *arguments: str | Path, **options: Any) -> subprocess.CompletedProcess[str]:
        """Run Python in the copy."""
        command = [sys.executable, *map(str, arguments)]
        options = {"env": self.environment, "timeout": 500} | options
        return subprocess.run(command, cwd=self.folder, capture_output=True, text=True, **options)

    def ptl(self, *arguments: str | Path, **options: Any) -> subprocess.CompletedProcess[str]:
        """Run the copy's command line."""
        return self.python("-m", "ptl", *arguments, **options)

    def snakemake(self, *arguments: str | Path, cores: int = 2, **options: Any) -> subprocess.CompletedProcess[str]:
        """Run Snakemake in the copy."""
        return self.python("-m", "snakemake", f"-j{cores}", *arguments, **options)

    def make(self, *arguments: str | Path, cores: int = 2) -> str:
        """Run Snakemake in the copy, which must succeed; return what it printed."""
        done = self.snakemake(*arguments, cores=cores)
        assert done.returncode == 0, done.stderr[-5000:]
        return done.stdout + done.stderr

    def waiting(self, *arguments: str | Path) -> dict[str, int]:
        """Number of jobs of each rule that would run."""
        return job_counts(self.make(*arguments, "-n", "--quiet", "reason"))

    def files(self, *folders: str) -> dict[str, bytes]:
        """Content of all files below some folders, by path."""
        paths = [path for folder in folders for path in sorted((self.folder / folder).rglob("*")) if path.is_file()]
        return {path.relative_to(self.folder).as_posix(): path.read_bytes() for path in paths}


def imports_of_a_fork(folder: Path, job: str, *modules: str, maps: tuple[str, ...] = ()) -> set[str]:
    """What a job, but for codecs, still imports when the server that it is forked from has imported these modules."""
    code = (
        "import socket, sys; from ptl.cli.forks.__main__ import exit_status, serve; "
        "serve(socket.socket(), *sys.argv.pop().split()); known = set(sys.modules); "
        "assert exit_status() == 0; print(*set(sys.modules) - known)"
    )
    command = [sys.executable, "-c", code, "run", "--job", job, *maps, "--output", "made.h5", " ".join(modules)]
    done = subprocess.run(
        command, cwd=folder, env=os.environ | {"PYTHONPATH": str(ROOT)}, stdin=subprocess.DEVNULL,
        capture_output=True, text=True,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return {name for name in done.stdout.split() if not name.startswith("encodings.")}


def job_counts(printed: str) -> dict[str, int]:
    """Read the table of jobs that Snakemake prints before it begins."""
    table = re.findall(r"^(\w+) +(\d+)$", printed, flags=re.M)
    return {name: int(count) for name, count in table if name != "total"}


def errors_of(done: subprocess.CompletedProcess[str]) -> list[str]:
    """Lines for the user of a command that failed, which must not show a traceback."""
    printed = done.stdout + done.stderr
    assert done.returncode != 0 and "Traceback" not in printed, printed[-3000:]
    return [line for line in printed.splitlines() if line.startswith("error:")]
