"""The second study: methods beyond the article's comparison on a population of maps.

``families``, ``maps``, ``population``  the maps: generators, sequences of tasks, the table of all maps
``methods``, ``finders``                methods and finders of subgoals beyond the article's
``design``, ``planned``                 the configuration, and the jobs that follow from it
``lives``, ``jobs``                     many lives in one process, to one file
``collect``, ``summary``                a row for each life and task; estimates for each family of maps
``lifelong``                            what is kept of an old task, and gained over a single-task expert
``figures``, ``page``                   presentation
"""
