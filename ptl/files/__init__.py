"""Files of a run: written whole with their origin, read and checked in one place."""
