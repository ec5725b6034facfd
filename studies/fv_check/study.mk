# The check of policy reuse, included by the Makefile.

SNAKEFILES += studies/fv_check/Snakefile

.PHONY: fv-check

fv-check: build  ## Policy reuse in the experiment of its authors: reports/fv_check/ (two minutes).
	$(SNAKEMAKE) --snakefile studies/fv_check/Snakefile
	@.venv/bin/ptl verify reports/fv_check --against published --exit-zero
