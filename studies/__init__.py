"""Studies beside the reproduction, a folder each; deleting a folder removes its study."""
