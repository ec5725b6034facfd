"""No transfer: every task is learned from nothing, the base of all comparisons."""

from __future__ import annotations

from ptl.agent.plan import Plan
from ptl.methods._base import BaseMethod


class Method(BaseMethod):
    """Epsilon-greedy Q-learning from Q = 0 (stated by the article)."""

    label = "No transfer"
    colour = "#6b6b6b"

    def plan(self) -> Plan:
        return Plan()
