"""Measurements of speed and cost, outside of the package: ``make benchmark``, or ``python -m benchmarks``.

`learners`, `numba_loops` and `jax_loop` hold learners of one task; `speed` compares their rates and `surveys` times
the survey of figure 8 by two methods; `jobs` times learning jobs and a whole run; `scaling` measures how cost grows;
`pages` lays out the tables.
"""
