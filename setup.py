"""Builds the compiled parts of ptl; everything else is declared in pyproject.toml."""

import hashlib
import runpy
import shutil
from pathlib import Path

import numpy
from Cython.Build import cythonize
from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext
from setuptools.command.build_py import build_py
from setuptools.errors import CCompilerError, CompileError, ExecError, PlatformError

# run, not imported, because the package is not built yet
EXTENSIONS = runpy.run_path("ptl/extensions.py")["EXTENSIONS"]
SOURCES = {name: [f"ptl/{source}" for source in sources] for name, sources in EXTENSIONS.items()}


def digest(paths: list[str]) -> str:
    return hashlib.sha256(b"".join(Path(path).read_bytes() for path in paths)).hexdigest()


class BuildWithAdvice(build_ext):
    """Says in one sentence what is missing when there is no C compiler."""

    def build_extension(self, ext: Extension) -> None:
        try:
            super().build_extension(ext)
        except (CCompilerError, CompileError, ExecError, PlatformError) as error:
            raise SystemExit(
                f"error: {ext.name} could not be compiled: ptl needs a C compiler and the Python headers"
                f" (on Debian or Ubuntu: apt-get install build-essential python3-dev). Cause: {error}"
            ) from None


class BuildWithWorkflow(build_py):
    """Puts workflow and studies into a wheel, where `ptl` finds them; an editable install uses the checkout's."""

    def run(self) -> None:
        super().run()
        if not self.editable_mode:
            for place in ("ptl/workflow", "ptl/profiles", "ptl/config", "studies"):
                folder, target = Path(place).name, Path(self.build_lib, place)
                shutil.rmtree(target, ignore_errors=True)
                if Path(folder).is_dir():  # studies can be removed
                    shutil.copytree(folder, target, ignore=shutil.ignore_patterns("__pycache__", "tests"))


extensions = [
    Extension(
        name,
        sources[:1],
        depends=sources,
        include_dirs=[numpy.get_include()],
        define_macros=[
            ("PTL_SOURCE_DIGEST", f'"{digest(sources)}"'),
            ("NPY_NO_DEPRECATED_API", "NPY_1_7_API_VERSION"),
        ],
        # The same bits on every machine: no contraction to fused operations, nothing native.
        extra_compile_args=["-O3", "-funroll-loops", "-ffp-contract=off"],
    )
    for name, sources in SOURCES.items()
]

setup(ext_modules=cythonize(extensions), cmdclass={"build_ext": BuildWithAdvice, "build_py": BuildWithWorkflow})
