"""PTL with a skill to the frontier and a prior based on paths: a proposal of ours."""

from __future__ import annotations

from studies.beyond.methods.ptl_frontier import Method as Frontier


class Method(Frontier):
    """As `ptl_frontier`, with the prior of `ptl_path_prior` (ours)."""

    label = "PTL + frontier, path prior (ours)"
    colour = "#006837"
    path_prior = True
