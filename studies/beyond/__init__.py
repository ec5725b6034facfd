"""The second study: methods beyond the article's comparison on a population of maps.

``design``   from config/beyond.yaml to jobs
``running``  many lives in one process, to one file
``collect``  from these files to a row for each life, and for each task
``summary``  estimates for each family of maps
"""
