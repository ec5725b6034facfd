# The second study, included by the Makefile.

BEYOND = $(SNAKEMAKE) --snakefile studies/beyond/Snakefile
SNAKEFILES += studies/beyond/Snakefile

.PHONY: beyond beyond-smoke beyond-1000 beyond-3000 beyond-slow tune-beyond

beyond: build  ## The second study: other methods on maps that nobody chose, reports/beyond/index.html (a quarter of an hour).
	$(BEYOND)
	@echo "Open reports/beyond/index.html in a browser."
	@.venv/bin/ptl verify reports/beyond --against published --exit-zero

beyond-smoke: build  ## The second study on a small configuration, in two minutes.
	$(BEYOND) --configfile studies/beyond/config/beyond_smoke.yaml
	@echo "Open reports/beyond_smoke/index.html in a browser."

beyond-1000 beyond-3000 beyond-slow: build  ## The second study on maps of about 1000 or 3000 states, or of slow rivals (hours).
	$(BEYOND) --configfile studies/beyond/config/$(subst -,_,$@).yaml
	@echo "Open reports/$(subst -,_,$@)/index.html in a browser."

tune-beyond: build  ## Tune rivals of the second study on the tuning band again, studies/beyond/config/tuned.csv.
	.venv/bin/python -m studies.beyond.tuning
