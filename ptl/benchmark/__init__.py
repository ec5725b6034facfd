"""Measurements of what the package costs; no part of the reproduction depends on them.

`speed` compares the kernel with other `contestants`, and `figure8` the survey of subgoals by two methods; `startup`
measures the phases of a learning job and `run` a whole run; `probes` make one measurement each and `scaling` fits how
they grow; `pages` writes the results.
"""
