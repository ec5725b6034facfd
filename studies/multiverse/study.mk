# The multiverse, included by the Makefile.

SNAKEFILES += studies/multiverse/Snakefile

.PHONY: multiverse

multiverse: build  ## Draw all that the article leaves open: reports/multiverse/ (half an hour).
	$(SNAKEMAKE) --snakefile studies/multiverse/Snakefile
	@.venv/bin/ptl verify reports/multiverse --against published --exit-zero
