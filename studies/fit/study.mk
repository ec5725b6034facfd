# The search for a reading that fits, included by the Makefile.

.PHONY: fit

fit: build  ## Repeat the frozen search for drawings and settings that fit the claims: reports/fit/ (an hour).
	.venv/bin/python -m studies.fit.search
