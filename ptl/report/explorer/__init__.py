"""The explorer: one HTML page, complete in itself, in which the learning of a run can be watched.

``data`` turns learning files into the data set of the page, ``replay`` learns them again to note probabilities and the
steps of first episodes, and ``page`` joins data, style and scripts (``web``) into one file.
"""
