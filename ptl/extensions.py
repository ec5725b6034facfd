"""The compiled modules and their sources, for setup.py and for the digests of `ptl.files.provenance`."""

EXTENSIONS = {
    "ptl.agent._kernel": ("agent/_kernel.pyx", "agent/_kernel.pxd"),
    "ptl.agent._episodes": ("agent/_episodes.pyx", "agent/_kernel.pyx", "agent/_kernel.pxd"),
    "ptl.agent._paths": ("agent/_paths.pyx",),
    "ptl.agent._selection": ("agent/_selection.pyx",),
    "ptl.world._graph": ("world/_graph.pyx",),
    "ptl.learning._survey": ("learning/_survey.pyx", "agent/_kernel.pyx", "agent/_kernel.pxd"),
}
"""Sources of each compiled module below ptl/, the .pyx first."""
