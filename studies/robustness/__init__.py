"""The robustness study: how verdicts depend on the choices that the article leaves open.

``design``    from the study's file to its points (one unknown at a time, a Latin hypercube of all)
``running``   one setting learned in one process
``jobs``      the job and the result file of each setting
``verdicts``  from a result file to the verdict on every claim
``summary``   from the verdicts of all settings to shares, ranks and tables
``pages``     the tables
``figure``    the heat map
"""
