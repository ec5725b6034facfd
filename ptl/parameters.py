"""The hyper-parameters of learning, by the names of the configuration file.

Defaults are those of the reconstruction (docs/reconstruction.md says for each whether the article states it, a source
gives it or we chose it). Ranges are checked here, so a bad value is refused from whichever side it comes.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass, field, fields
from typing import Any, ClassVar

from ptl.errors import UserError

PRIOR_FORMS = ("exponential", "gaussian", "uniform")
SKILL_USES = ("reselect", "lead_in")


def _number(default: float, low: float, high: float, *, open_low: bool = False, open_high: bool = False) -> Any:
    return field(default=default, metadata={"range": (low, high, open_low, open_high)})


def _choice(default: str, options: tuple[str, ...]) -> Any:
    return field(default=default, metadata={"options": options})


class _Checked:
    """Refuses values outside the ranges given beside the fields."""

    group: ClassVar[str]

    def __post_init__(self) -> None:
        for item in fields(self):  # type: ignore[arg-type]
            value = getattr(self, item.name)
            key = f"{self.group}.{item.name}"
            if isinstance(item.default, bool):
                _require(isinstance(value, bool), key, value, "true or false")
            elif "options" in item.metadata:
                options = item.metadata["options"]
                _require(value in options, key, value, "one of " + ", ".join(options))
            elif "range" in item.metadata:
                _check_number(key, value, item.default, *item.metadata["range"])


def _check_number(key: str, value: Any, default: Any, low: float, high: float, open_low: bool, open_high: bool) -> None:
    whole = isinstance(default, int)
    kind = "a whole number" if whole else "a number"
    bounds = f"{kind} in {'(' if open_low else '['}{low:g}, {high:g}{')' if open_high else ']'}"
    right_type = isinstance(value, int) if whole else isinstance(value, int | float)
    _require(right_type and not isinstance(value, bool), key, value, bounds)
    above = value > low if open_low else value >= low
    below = value < high if open_high else value <= high
    _require(above and below, key, value, bounds)


def _require(good: bool, key: str, value: Any, wanted: str) -> None:
    if not good:
        raise UserError(f"configuration key {key}: {value!r} is not allowed; give {wanted}")


@dataclass(frozen=True)
class Learning(_Checked):
    """Tabular Q-learning (section 'Learner' of the reconstruction)."""

    group = "learning"
    episodes: int = _number(200, 1, 10**6)
    alpha: float = _number(0.05, 0, 1, open_low=True)
    gamma: float = _number(0.95, 0, 1, open_low=True)
    epsilon: float = _number(0.1, 0, 1)
    max_steps: int = _number(10**7, 1, 10**12)


@dataclass(frozen=True)
class Skills(_Checked):
    """Selection and use of skills (PTL)."""

    group = "skills"
    prior_form: str = _choice("exponential", PRIOR_FORMS)
    prior_width: float = _number(0.1, 0, 1000, open_low=True)
    likelihood_exponent: float = _number(2.0, 0, 100)
    likelihood_weight: float = _number(0.5, 0, 1, open_low=True)
    patience: float = _number(1.0, 0, 10**6, open_low=True)
    patience_growth: float = _number(2.0, 1, 1000)
    skill_use: str = _choice("reselect", SKILL_USES)
    null_skill: bool = True


@dataclass(frozen=True)
class Subgoals(_Checked):
    """Discovery of subgoals and update of the library."""

    group = "subgoals"
    trajectories: int = _number(30, 1, 10**6)
    cover_radius: int = _number(2, 0, 10**6)
    novelty: float = _number(0.2, 0, 1)
    threshold: float = _number(0.2, 0, 1)


@dataclass(frozen=True)
class PolicyReuse(_Checked):
    """PRQ-learning (Fernandez and Veloso)."""

    group = "policy_reuse"
    psi: float = _number(1.0, 0, 1)
    psi_decay: float = _number(0.95, 0, 1, open_high=True)
    temperature: float = _number(0.0, 0, 10**6)
    temperature_step: float = _number(0.05, 0, 10**6)


@dataclass(frozen=True)
class Parameters:
    """All hyper-parameters of learning, in the groups of the configuration file."""

    learning: Learning = field(default_factory=Learning)
    skills: Skills = field(default_factory=Skills)
    subgoals: Subgoals = field(default_factory=Subgoals)
    policy_reuse: PolicyReuse = field(default_factory=PolicyReuse)

    @classmethod
    def from_dict(cls, groups: dict[str, Any]) -> Parameters:
        """Build from nested dictionaries; missing keys take their defaults, unknown ones raise UserError."""
        kinds = {"learning": Learning, "skills": Skills, "subgoals": Subgoals, "policy_reuse": PolicyReuse}
        _refuse_unknown(groups, kinds, "")
        built = {}
        for name, kind in kinds.items():
            values = groups.get(name, {})
            _refuse_unknown(values, [item.name for item in fields(kind)], f"{name}.")
            built[name] = kind(**values)
        return cls(**built)

    def to_dict(self) -> dict[str, Any]:
        """Nested dictionaries that `from_dict` turns back."""
        return asdict(self)

    def replace(self, **changes: Any) -> Parameters:
        """A copy with single values changed, named ``group__key`` (``learning__alpha=0.1``)."""
        groups = self.to_dict()
        for name, value in changes.items():
            group, _, key = name.partition("__")
            groups.setdefault(group, {})[key] = value
        return Parameters.from_dict(groups)


def _refuse_unknown(given: Any, known: Any, prefix: str) -> None:
    if not isinstance(given, dict):
        raise UserError(f"configuration key {prefix.rstrip('.') or 'parameters'}: give keys and values, not {given!r}")
    for key in given:
        if key not in known:
            raise UserError(f"configuration key {prefix}{key}: unknown; known are {', '.join(known)}")
