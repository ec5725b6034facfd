"""Studies that extend the reproduction, one folder each; deleting a folder removes its study."""
