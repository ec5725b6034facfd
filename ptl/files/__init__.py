"""What a run keeps: whole files with their origin, read and checked in one place."""
