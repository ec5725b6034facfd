"""The robustness study: which verdicts hang on what the article leaves open.

``design``    from config/robustness.yaml to settings (one unknown at a time, a Latin hypercube of all)
``worlds``    maps that differ from the reference ones: start cell, room size, goal depth
``running``   one setting learned in one process, to one raw file
``verdicts``  from a raw file to the verdict on every claim
``summary``   from the verdicts of all settings to shares, ranks and tables
"""
