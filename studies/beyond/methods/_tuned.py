"""What was tuned on the tuning band: the chosen rows of config/tuned.csv, which `make tune-beyond` makes."""

from __future__ import annotations

from collections.abc import Mapping

OPTIMISTIC: dict[float, dict[str, float]] = {
    0.0: {"learning__alpha": 1.0},
    0.1: {"learning__alpha": 0.8},
    0.2: {"learning__alpha": 0.8},
}
"""Settings of `optimistic` by the probability of a slip."""

POLICY_REUSE: dict[float, dict[str, float]] = {
    0.0: {"policy_reuse__psi_decay": 0.98, "policy_reuse__temperature_step": 50000.0},
    0.1: {"policy_reuse__psi_decay": 0.98, "policy_reuse__temperature_step": 50000.0},
    0.2: {"policy_reuse__psi_decay": 0.99, "policy_reuse__temperature_step": 50000.0},
}
"""Settings of `policy_reuse` by the probability of a slip."""


def tuned_at(table: Mapping[float, dict[str, float]], slip: float) -> dict[str, float]:
    """Return the settings chosen at a slip, or at the nearest one that was tuned, the lower of two equally near."""
    return table[min(sorted(table), key=lambda tuned: abs(tuned - slip))]
