"""Methods of the second study, one file each: rivals of PTL, PTL with other parts, and proposals of ours.

They are not part of the article's comparison. `reference` makes a reference such as
``studies.beyond.methods.rmax:Method`` from an identifier.
"""

from __future__ import annotations

from pathlib import Path

from ptl import methods


def names() -> list[str]:
    """Return the identifiers of these methods, in alphabetical order."""
    return sorted(path.stem for path in Path(__file__).parent.glob("[!_]*.py"))


def reference(name: str) -> str:
    """Return the reference of a method of this folder by its identifier; any other reference as it is."""
    return f"{__name__}.{name}:Method" if name in names() else name


def module_of(method: str) -> str:
    """Return the module of this package that defines a method, empty if it is defined outside."""
    place = reference(method).partition(":")[0]
    if place in methods.names():
        return f"ptl.methods.{place}"
    own = {f"{__name__}.{name}" for name in names()} | {f"ptl.methods.{name}" for name in methods.names()}
    return place if place in own else ""
