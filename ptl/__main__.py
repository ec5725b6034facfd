"""``python -m ptl`` is the command line."""

from ptl.cli import main

main()
