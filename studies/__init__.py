"""Studies beside the reproduction, a folder each, which can be removed."""
