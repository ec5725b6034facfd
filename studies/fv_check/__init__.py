"""Policy reuse in the experiment of its authors, Fernandez and Veloso: a check of the class used in the comparison.

``experiment``  their setting, and how it is learned
``jobs``        the configuration, and the result file of each library
``figure``      mean gain against trials
``page``        mean gain over all trials, as a table
"""
