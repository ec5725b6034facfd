"""What follows from the files: measures, estimates with intervals, verdicts, and how robust they are."""
