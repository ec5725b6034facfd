"""What the package costs: speed beside other learners, growth of the cost with the problem, and where a run's time goes.

Nothing of the reproduction hangs on this room. `speed` compares the kernel with the `contestants`, `startup` takes a
learning job apart, `run_log` a whole run, `scaling` measures how the cost grows, and `pages` writes it all down.
"""
