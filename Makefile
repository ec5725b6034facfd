# The commands of the README. Each one does its own set-up in .venv and works in this folder; outside of it, only pip
# keeps its cache.

PYTHON ?= python3
CORES ?= 2
TEST_TOOLS = .venv/.test-tools
BENCHMARK_TOOLS = .venv/.benchmark-tools
SNAKEMAKE = .venv/bin/ptl workflow --cores $(CORES)
SANITIZED = build/sanitizers
SANITIZE = -fsanitize=address,undefined
CALLS = 5000
SNAKEFILES = Snakefile

export PATH := $(CURDIR)/.venv/bin:$(PATH)
export PIP_DISABLE_PIP_VERSION_CHECK = 1

.DELETE_ON_ERROR:
.PHONY: help reproduce smoke report robustness fit benchmark reliability test test-slow test-browser test-exhaustive test-slurm test-sanitizers test-all lint format docs build clean lock FORCE

help:  ## Show this list.
	@grep -hE '^[a-z-]+:.*##' $(MAKEFILE_LIST) | sed -E 's/:.*## /\t/' | expand -t 14

# The published products are tracked. Before a first run they are made to look old, so that it makes all of them again,
# even if it is interrupted; without git a copy is kept to compare with.
reproduce: build  ## Everything: all runs, tables, figures, verdicts and reports/published/report.html.
	$(if $(wildcard .git .published results/published),,$(if $(wildcard reports/published),cp -R reports/published .published))
	$(if $(wildcard results/published),,$(if $(wildcard reports/published),find reports/published -type f -exec touch -t 200001010000 {} +))
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

robustness: build  ## Vary what the article leaves open: reports/published/robustness/ (a quarter of an hour).
	$(SNAKEMAKE) robustness

fit: build  ## Search for drawings and settings that fit the claims: reports/published/fit/ (half an hour).
	$(SNAKEMAKE) fit

benchmark: $(BENCHMARK_TOOLS) build  ## Speed, a whole run and growth of cost on this machine: reports/published/benchmark.md (15 minutes).
	$(SNAKEMAKE) benchmark --forcerun compare_speed measure_scaling

reliability: $(TEST_TOOLS) build  ## Try faults, rubbish and other surroundings: the figures in docs/reliability.md.
	.venv/bin/python tests/reliability.py $(if $(shell command -v slurmctld),--slurm)

test: $(TEST_TOOLS) build  ## The quick test suite.
	.venv/bin/python -m pytest -q -n $(CORES) -m "not slow and not browser and not slurm"

test-browser: $(TEST_TOOLS) build  ## Report and explorer in headless Chromium (needs chromium and chromedriver).
	.venv/bin/python -m pytest -q -m browser

test-slow: $(TEST_TOOLS) build  ## Tests that take minutes: kills, tutorials, other surroundings.
	.venv/bin/python -m pytest -q -n $(CORES) --dist loadfile -m "slow and not exhaustive"

test-exhaustive: $(TEST_TOOLS) build  ## Tests that take many minutes: repeated kills, another Python, one core.
	.venv/bin/python -m pytest -q -n $(CORES) --dist loadfile -m exhaustive

test-slurm: $(TEST_TOOLS) build  ## Tests on a Slurm cluster of one node, started here as root.
	.venv/bin/python -m pytest -q -m slurm

# A copy, because the extensions lie beside their sources. Tests at whose limits the sanitizers' own memory counts are
# left out; the allocator of Python would hide reads behind the end of small objects.
test-sanitizers: $(TEST_TOOLS) build  ## Kernel, graph and survey under address and undefined-behaviour sanitizers (gcc).
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

lint: $(TEST_TOOLS) build  ## Style and consistency of code and workflow.
	.venv/bin/ruff check .
	.venv/bin/ruff format --check .
	.venv/bin/mypy
	.venv/bin/snakefmt --check workflow $(SNAKEFILES)
	.venv/bin/lint-imports
	for file in $(SNAKEFILES); do .venv/bin/snakemake --lint --snakefile $$file || exit 1; done

format: $(TEST_TOOLS)  ## Bring code and workflow into the style that lint checks.
	.venv/bin/ruff check --fix .
	.venv/bin/ruff format .
	.venv/bin/snakefmt workflow $(SNAKEFILES)

docs: build  ## Bring config/README.md, docs/file-format.md and README.md up to date with the code and the published run.
	.venv/bin/ptl config-docs
	.venv/bin/ptl readme

build:  ## Install the package into .venv and compile its kernel.
	@$(PYTHON) make_venv.py built

# What is installed in .venv is kept in its stamp; these files are never made.
.venv/.%: FORCE
	@$(PYTHON) make_venv.py $*

FORCE:

clean:  ## Remove results and workflow state (published products and .venv stay).
	rm -rf results logs .snakemake build

lock: $(TEST_TOOLS)  ## Resolve the locked requirements anew (needs uv).
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
