"""The subcommands of ``ptl``, one file each; ``ptl.cli`` loads only the one that is called."""
