# The robustness study, included by the Makefile.

SNAKEFILES += studies/robustness/Snakefile

.PHONY: robustness

robustness: build  ## Vary what the article leaves open: reports/robustness/ (a quarter of an hour).
	$(SNAKEMAKE) --snakefile studies/robustness/Snakefile
	@.venv/bin/ptl verify reports/robustness --against published --exit-zero
