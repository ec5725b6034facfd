# The commands of the README. Each one does its own set-up in .venv and works in this folder; outside of it, only pip
# keeps its cache.

PYTHON ?= python3
CORES ?= 2
SNAKEMAKE = .venv/bin/ptl workflow --cores $(CORES)
SANITIZED = build/sanitizers
SANITIZE = -fsanitize=address,undefined
CALLS = 5000
SNAKEFILES = Snakefile

# The steps that make .venv, each with its stamp, whose name has the checksum of the files that the step is made from.
stamp = .venv/$1-$(firstword $(shell cat $2 | cksum))
PYX := $(wildcard ptl/*/*.pyx)
run-tools := $(call stamp,run-tools,requirements.lock)
test-tools := $(call stamp,test-tools,requirements-test.lock)
benchmark-tools := $(call stamp,benchmark-tools,requirements-benchmark.lock)
build := $(call stamp,build,setup.py pyproject.toml ptl/__init__.py ptl/extensions.py $(PYX) $(wildcard ptl/*/*.pxd))

export PATH := $(CURDIR)/.venv/bin:$(PATH)
export PIP_DISABLE_PIP_VERSION_CHECK = 1

.DELETE_ON_ERROR:
.PHONY: help reproduce smoke report benchmark test test-slow test-browser test-exhaustive test-slurm test-sanitizers test-all lint format docs build test-tools benchmark-tools clean lock FORCE

help:  ## Show this list.
	@grep -hE '^[a-z-]+:.*##' $(MAKEFILE_LIST) | sed -E 's/:.*## /\t/' | expand -t 14

# The published products are tracked; without git a copy of them is kept to compare with.
reproduce: build  ## Everything: all runs, tables, figures, verdicts and reports/published/report.html.
	$(if $(wildcard .git .published results/published),,$(if $(wildcard reports/published),cp -R reports/published .published))
	$(SNAKEMAKE)
	$(SNAKEMAKE) --report reports/published/report.html
	@echo "Open reports/published/index.html in a browser; report.html beside it is Snakemake's report."
	@.venv/bin/ptl verify reports/published --against published --exit-zero

smoke: build  ## The same DAG on a small configuration, in under two minutes.
	$(SNAKEMAKE) --configfile config/smoke.yaml
	$(SNAKEMAKE) --configfile config/smoke.yaml --report reports/smoke/report.html
	@echo "Open reports/smoke/index.html in a browser; report.html beside it is Snakemake's report."

report: build  ## The page reports/published/report.html from what is there.
	$(SNAKEMAKE) --report reports/published/report.html

# The learners are tested first, because only here all of them are installed.
benchmark: test-tools benchmark-tools build  ## Speed, a whole run and growth of cost on this machine: reports/published/benchmark.md (15 minutes).
	.venv/bin/python -m pytest -q benchmarks -m "not slow"
	.venv/bin/python -m benchmarks

test: test-tools build  ## The quick test suite.
	.venv/bin/python -m pytest -q -n $(CORES) --dist loadfile -m "not slow and not browser and not slurm"

test-browser: test-tools build  ## Report and explorer in headless Chromium (needs chromium and chromedriver).
	.venv/bin/python -m pytest -q -m browser

test-slow: test-tools build  ## Tests that take minutes: kills, tutorials, other surroundings.
	.venv/bin/python -m pytest -q -n $(CORES) --dist loadfile -m "slow and not exhaustive"

test-exhaustive: test-tools build  ## Tests that take many minutes: repeated kills, another Python, one core.
	.venv/bin/python -m pytest -q -n $(CORES) --dist loadfile -m exhaustive

test-slurm: test-tools build  ## Tests on a Slurm cluster of one node, started here as root.
	.venv/bin/python -m pytest -q -m slurm

# A copy, because the extensions lie beside their sources. Tests at whose limits the sanitizers' own memory counts are
# left out; the allocator of Python would hide reads behind the end of small objects.
test-sanitizers: test-tools build  ## Kernel, graph and survey under address and undefined-behaviour sanitizers (gcc).
	rm -rf $(SANITIZED) && mkdir -p $(SANITIZED)
	cp -R ptl tests config pyproject.toml README.md Snakefile $(SANITIZED)
	sed 's/"-O3"/"-O1"/' setup.py > $(SANITIZED)/setup.py
	find $(SANITIZED)/ptl -name '_*.c' -delete -o -name '*.so' -delete
	cd $(SANITIZED) && CFLAGS="-g $(SANITIZE)" LDFLAGS="$(SANITIZE)" $(CURDIR)/.venv/bin/python setup.py -q build_ext --inplace
	cd $(SANITIZED) && LD_PRELOAD="$$($${CC:-gcc} -print-file-name=libasan.so)" PYTHONMALLOC=malloc PTL_CALLS=$(CALLS) \
	  ASAN_OPTIONS=detect_leaks=0 UBSAN_OPTIONS=halt_on_error=1:print_stacktrace=1 \
	  $(CURDIR)/.venv/bin/python -m pytest -q -p no:cacheprovider -n $(CORES) -m "not slow" tests/agent \
	  tests/learning/test_survey.py tests/world/test_gridworld.py

test-all: test test-slow test-exhaustive test-browser test-slurm  ## All of them.

lint: test-tools build  ## Style and consistency of code and workflow.
	.venv/bin/ruff check .
	.venv/bin/ruff format --check .
	.venv/bin/mypy
	.venv/bin/snakefmt --check Snakefile workflow ptl/skeleton studies
	.venv/bin/lint-imports
	for file in $(SNAKEFILES); do .venv/bin/snakemake --lint --snakefile $$file || exit 1; done

format: test-tools  ## Bring code and workflow into the style that lint checks.
	.venv/bin/ruff check --fix .
	.venv/bin/ruff format .
	.venv/bin/snakefmt Snakefile workflow ptl/skeleton studies

docs: build  ## Bring pages and records (RO-Crate, ReScience, Croissant) up to date with the code and the published run.
	.venv/bin/ptl docs

build:  ## Install the package into .venv and compile its kernel.

# One call at a time works on .venv, where there is flock and the file system has locks (-E 0: another call may hold this
# one now). What a killed call leaves behind holds the lock as well.
build test-tools benchmark-tools:
	@$(if $(shell flock -n -E 0 Makefile true 2> /dev/null && echo yes),flock Makefile) $(MAKE) --no-print-directory $($@)

# The folder that .venv was made in, which its scripts name; absent while packages are installed. So .venv is made anew
# in another folder, under another Python and after a step that was killed.
.venv/place: FORCE
	@[ "$$(cat $@ 2>&1)" = "$$(pwd -P)" ] && .venv/bin/python -c "import pip" 2> /dev/null || { rm -rf .venv && \
	  $(call try,$(PYTHON) -c "import sys; sys.exit(sys.version_info < (3, 11))",\
	    Python 3.11 or newer is needed; name one with 'make PYTHON=python3.12 ...') && \
	  $(call try,$(PYTHON) -m venv .venv,.venv cannot be made (on Debian or Ubuntu: apt-get install python3-venv)) && \
	  pwd -P > $@; }

# Exactly the locked packages. A package without a wheel is built with the locked tools, and no others.
$(run-tools): locked = requirements.lock
$(test-tools): locked = requirements-test.lock
$(benchmark-tools): locked = requirements-benchmark.lock
$(test-tools) $(benchmark-tools) $(build): $(run-tools)
$(run-tools) $(test-tools) $(benchmark-tools): .venv/place
	@echo Installing $(locked)
	@rm -f $(firstword $(subst -tools-,-tools-* ,$@)) && mv .venv/place .venv/unfinished
	@sed -n '/^setuptools==/,/[^\]$$/p' requirements.lock > .venv/setuptools.lock
	@$(INSTALL) --require-hashes --requirement .venv/setuptools.lock
	@$(INSTALL) --require-hashes --requirement $(locked)
	@mv .venv/unfinished .venv/place && touch $@

# Compiled anew from all sources, because the build compares times. Jobs may not be allowed to write bytecode, and would
# compile their modules every time.
$(build): $(if $(filter-out $(basename $(basename $(wildcard $(PYX:.pyx=.*.so)))),$(PYX:.pyx=)),FORCE)
	@echo Building ptl
	@$(call try,command -v $(firstword $(CC)) > /dev/null,\
	  no C compiler found; ptl needs one (on Debian or Ubuntu: apt-get install build-essential))
	@rm -rf .venv/build-* $(PYX:.pyx=.c) $(wildcard $(PYX:.pyx=.*.so)) .venv/lib/python*/site-packages/ptl[-_]*.dist-info
	@$(INSTALL) --no-deps --editable .
	@.venv/bin/python -m compileall -q ptl
	@touch $@

INSTALL = .venv/bin/python -m pip install --quiet --no-build-isolation
try = { $1 || { echo "error: $(strip $2)" >&2; exit 1; }; }

FORCE:

clean:  ## Remove results and workflow state (published products and .venv stay).
	rm -rf results logs .snakemake build

lock: test-tools  ## Resolve the locked requirements anew (needs uv).
	uv pip compile --quiet --universal --fork-strategy fewest --python-version 3.11 --generate-hashes \
	  --no-emit-index-url --no-header --no-annotate pyproject.toml requirements-build.in -o requirements.lock
	uv pip compile --quiet --universal --fork-strategy fewest --python-version 3.11 --generate-hashes \
	  --no-emit-index-url --no-header --no-annotate pyproject.toml requirements-build.in --extra test --extra slurm \
	  -c requirements.lock -o requirements-test.lock
	uv pip compile --quiet --universal --fork-strategy fewest --python-version 3.11 --generate-hashes \
	  --no-emit-index-url --no-header --no-annotate requirements-benchmark.in -c requirements.lock \
	  -o requirements-benchmark.lock

# Targets of studies, which also name their Snakefiles.
-include studies/*/study.mk
