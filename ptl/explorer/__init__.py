"""The explorer: one HTML page, complete in itself, in which the learning of a run can be watched.

``data`` turns learning files into a compact data set, ``replay`` works out from them how likely each skill
was, ``encoding`` packs the numbers, and ``page`` joins data, style and scripts (``web``) into one file.
"""
