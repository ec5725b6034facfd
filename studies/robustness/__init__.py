"""The robustness study: how verdicts depend on the choices that the article leaves open.

``design``    from config/robustness.yaml to settings (one unknown at a time, a Latin hypercube of all)
``running``   one setting learned in one process, to one raw file
``verdicts``  from a raw file to the verdict on every claim
``summary``   from the verdicts of all settings to shares, ranks and tables
"""
