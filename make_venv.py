"""Bring .venv into the state that the Makefile asks for: ``python3 make_venv.py STAGE...``, stages of `STAGES`.

A stage is done when the stamp says so; whatever ends this program between two stamps (a signal, a second start, a full
disk) leaves none, and the next call begins anew. The stamp holds all that a stage depends on: the place of .venv, which
scripts in it name, its Python, and the content of the files that are installed from, never their times.
"""

from __future__ import annotations

import fcntl
import hashlib
import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent
VENV = ROOT / ".venv"
PYTHON = VENV / "bin/python"
STAMP = VENV / ".stamp"
LOCK = VENV / ".lock"
LOG = VENV / "build.log"

STAGES = {
    "run-tools": ["requirements.lock"],
    "test-tools": ["requirements-test.lock"],
    "benchmark-tools": ["requirements-benchmark.lock"],
    "built": [
        "setup.py", "pyproject.toml", "requirements.lock", "ptl/__init__.py", "ptl/extensions.py", "ptl/**/*.pyx",
        "ptl/**/*.pxd",
    ],
}  # fmt: skip
"""Files that each stage is made from; all but the first one need that one."""

GENERATED = (".c", ".*.so")
"""Endings of what is made from a .pyx file."""


def main(wanted: list[str]) -> None:
    VENV.mkdir(exist_ok=True)
    with LOCK.open("a+") as lock:
        take(lock)
        done = begun(lock)
        for stage in dict.fromkeys(["run-tools", *wanted]):
            digest = digest_of(stage)
            if done.get(stage) == digest and (stage != "built" or extensions_are_there()):
                continue
            STAMP.unlink(missing_ok=True)
            left = {name: value for name, value in done.items() if name != stage}
            try:
                build(lock) if stage == "built" else install(STAGES[stage][0], lock)
            except Failed as failure:
                if packages_are_whole():
                    write_stamp(left)
                sys.exit(f"error: {failure}")
            done = {**left, stage: digest}
            write_stamp(done)


class Failed(Exception):
    """A step did not succeed; the message is for the user."""


def take(lock) -> None:
    """Wait until no other call is at work on .venv.

    Programs that a killed one left behind hold the lock as well: it is their standard input, which whatever they start
    inherits.
    """
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        print("waiting for another 'make' that is at work on .venv", file=sys.stderr, flush=True)
        fcntl.flock(lock, fcntl.LOCK_EX)


def begun(lock) -> dict[str, str]:
    """Return the digests of the stages that are done, in a .venv that is whole; make one if there is none."""
    try:
        stamp = json.loads(STAMP.read_text(encoding="utf-8"))
        if (stamp["place"], stamp["python"]) == (str(VENV), python_of(PYTHON)):
            return stamp["stages"]
    except (OSError, ValueError, KeyError, TypeError, subprocess.CalledProcessError):
        pass
    if sys.version_info < (3, 11):
        sys.exit("error: Python 3.11 or newer is needed; name one with 'make PYTHON=python3.12 ...'")
    python = base_python()
    for path in VENV.iterdir():
        if path != LOCK:
            shutil.rmtree(path) if path.is_dir() and not path.is_symlink() else path.unlink()
    made = subprocess.run([python, "-m", "venv", str(VENV)], stdin=lock, capture_output=True, text=True, check=False)
    if made.returncode:
        sys.exit(f"error: .venv could not be made (on Debian or Ubuntu: apt-get install python3-venv): {made.stdout}")
    write_stamp({})
    return {}


def base_python() -> str:
    """Return the Python that runs this program, or the one behind it: .venv comes first in PATH."""
    python = Path(sys.executable).resolve()
    return str(Path(sys.base_prefix, "bin/python3") if VENV.resolve() in python.parents else python)


def write_stamp(stages: dict[str, str]) -> None:
    unfinished = STAMP.with_suffix(".unfinished")
    unfinished.write_text(json.dumps({"place": str(VENV), "python": python_of(PYTHON), "stages": stages}))
    unfinished.replace(STAMP)


def python_of(python: Path) -> str:
    """Return the version of a Python; a .venv stops working when the one that it was made with goes."""
    asked = [str(python), "-I", "-S", "-c", "import sys; print(sys.version)"]
    return subprocess.run(asked, capture_output=True, text=True, check=True).stdout


def sources(stage: str) -> list[Path]:
    return sorted(path for pattern in STAGES[stage] for path in ROOT.glob(pattern))


def digest_of(stage: str) -> str:
    digest = hashlib.sha256()
    for path in sources(stage):
        digest.update(f"{path.relative_to(ROOT)}\0{path.stat().st_size}\0".encode() + path.read_bytes())
    return digest.hexdigest()


def install(requirements: str, lock) -> None:
    """Install exactly the locked packages. A package without a wheel is built with the locked tools, and no others."""
    print(f"Installing {requirements}", flush=True)
    tools = VENV / "build-tools.lock"
    text = (ROOT / "requirements.lock").read_text(encoding="utf-8")
    tools.write_text(re.search(r"^setuptools==(?:.*\\\n)*.*\n", text, flags=re.M)[0])
    for path in (tools, ROOT / requirements):
        pip(["--quiet", "--require-hashes", "--no-build-isolation", "--requirement", str(path)], lock)


def build(lock) -> None:
    """Install the package so that it runs from this folder, and compile its extensions."""
    print("Building ptl", flush=True)
    if not shutil.which(os.environ.get("CC", "cc").split()[0]):
        raise Failed("no C compiler found; ptl needs one (on Debian or Ubuntu: apt-get install build-essential)")
    for path in generated():  # the build compares times, which say nothing of a copied or half-written file
        path.unlink()
    with LOG.open("w") as log:
        try:
            pip(["--no-deps", "--no-build-isolation", "--editable", str(ROOT)], lock, stdout=log, stderr=log)
        except Failed:
            print(LOG.read_text(errors="replace"), file=sys.stderr)
            raise Failed("the package could not be built; see the lines above") from None
    # Jobs may not be allowed to write bytecode, and would compile anew every time.
    subprocess.run([str(PYTHON), "-m", "compileall", "-q", "ptl"], cwd=ROOT, check=True)


def pip(arguments: list[str], lock, **streams) -> None:
    command = [str(PYTHON), "-m", "pip", "--disable-pip-version-check", "install", *arguments]
    if subprocess.run(command, cwd=ROOT, stdin=lock, check=False, **streams).returncode:
        raise Failed("the packages could not be installed; see the lines above")


def packages_are_whole() -> bool:
    """Return whether every package has the list of its files, which pip writes last."""
    return all((package / "RECORD").exists() for package in VENV.glob("lib/*/site-packages/*.dist-info"))


def generated() -> list[Path]:
    modules = [path for path in sources("built") if path.suffix == ".pyx"]
    return [path for module in modules for end in GENERATED for path in module.parent.glob(module.stem + end)]


def extensions_are_there() -> bool:
    modules = [path for path in sources("built") if path.suffix == ".pyx"]
    return all(any(module.parent.glob(module.stem + ".*.so")) for module in modules)


if __name__ == "__main__":
    try:
        main(sys.argv[1:])
    except KeyboardInterrupt:
        sys.exit(130)
    except OSError as error:
        sys.exit(f"error: .venv could not be made: {error}")
