"""What the package costs: speed beside other learners, growth of the cost with the problem, where a run's time goes.

Nothing of the reproduction hangs on this room. `speed` compares the kernel with other `contestants`, `startup` takes
a learning job apart and `run_log` a whole run; `probes` measure one thing each and `scaling` fits how they grow;
`pages` writes all of it down.
"""
