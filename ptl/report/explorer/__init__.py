"""The explorer: one self-contained HTML page that shows the learning of a run.

``data`` turns learning files into the data set of the page, ``replay`` learns them again to note probabilities and the
steps of first episodes, and ``page`` joins data, style and scripts (``web``) into one file.
"""
