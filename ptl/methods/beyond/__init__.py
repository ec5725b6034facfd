"""Methods of the second study, one file each: rivals of PTL, PTL with other parts, and proposals of ours.

They are no part of the article's comparison. A reference is ``ptl.methods.beyond.rmax:Method``; `reference` makes it
from the identifier.
"""

from __future__ import annotations

from pathlib import Path


def names() -> list[str]:
    """Return the identifiers of these methods, in alphabetical order."""
    return sorted(path.stem for path in Path(__file__).parent.glob("[!_]*.py"))


def reference(name: str) -> str:
    """Return the reference of a method of this folder by its identifier; any other reference as it is."""
    return f"{__name__}.{name}:Method" if name in names() else name
