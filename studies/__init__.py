"""Studies beside the reproduction; each is a folder that can be removed."""
