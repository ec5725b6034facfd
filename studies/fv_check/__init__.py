"""Policy reuse in the experiment of its authors, Fernandez and Veloso: a check of the class used in the comparison.

``experiment``  their setting, and how it is learned by the class
``simulator``   policy reuse with a noisy robot and other rules for ties, many runs at once
``readings``    the runs of one reading of the experiment
``jobs``        the configuration, and the result files
``page``        gains under each reading as a table, and what they say
``figure``      the same as a figure
"""
