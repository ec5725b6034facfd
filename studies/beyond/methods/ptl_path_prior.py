"""PTL with a prior based on paths: a proposal of ours."""

from __future__ import annotations

from studies.beyond.methods.ptl_frontier import Method as Frontier


class Method(Frontier):
    """As `ptl`, with a prior over seen paths instead of straight lines; no skill to the frontier (ours).

    Both changes are described in `studies.beyond.methods.ptl_frontier`.
    """

    label = "PTL, path prior (ours)"
    colour = "#a6d96a"
    offers_frontier = False
    path_prior = True
