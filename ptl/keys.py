"""Typed keys of a configuration: their descriptions, the check of values, and the messages for wrong values."""

import datetime
import math
from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager, suppress
from typing import Annotated, Any, Literal, NamedTuple, Self, get_args, get_origin

import msgspec
from msgspec import Meta, Struct

from ptl.errors import UserError


class ConfigurationError(UserError):
    """A key that is unknown or missing, or a value that is not allowed.

    Attributes
    ----------
    key : str
        Full name of the key, such as ``learning.alpha``.
    problem : str
        The value and the constraint.
    """

    def __init__(self, key: str, problem: str) -> None:
        super().__init__(f"configuration key {key}: {problem}" if key else f"configuration: {problem}")
        self.key, self.problem = key, problem

    @classmethod
    def of_value(cls, key: str, value: object, wanted: str) -> Self:
        """Refuse a value."""
        problem = "has no value" if value is None else f"{shortened(as_written(value))} is not allowed"
        return cls(key, f"{problem}; give {wanted}")


def key(description: str, mark: str = "", wanted: str = "", **constraints: Any) -> Meta:
    """Describe a key: a sentence, the mark of its default, its range; ``wanted`` puts a pattern into words."""
    return Meta(description=description, extra={"mark": mark, "wanted": wanted}, **constraints)


def text(characters: str, wanted: str, length: int = 64) -> dict[str, Any]:
    """Return the constraints of a text that consists of ``characters`` (a regular expression)."""
    # $ also matches before a last line end
    return {"pattern": rf"^{characters}(?![\s\S])", "max_length": length, "wanted": wanted}


class _FlatKeys(msgspec.StructMeta):
    """Takes keys of inner groups by their last name (``alpha`` for ``learning.alpha``) if only one group has it."""

    def __call__(cls, *arguments: Any, **keys: Any) -> Any:
        if not keys.keys() <= {*cls.__struct_fields__}:  # type: ignore[attr-defined]
            keys = _nested(cls, keys)  # type: ignore[arg-type]
        return super().__call__(*arguments, **keys)


class Group(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, metaclass=_FlatKeys):
    """Keys and values of the configuration; a wrong value raises `ConfigurationError`, however it is made."""

    def __post_init__(self) -> None:
        for field in msgspec.structs.fields(self):
            value = getattr(self, field.name)
            with _under(field.name):
                msgspec.structs.force_setattr(self, field.name, _checked(field.type, value))

    @classmethod
    def from_dict(cls, given: Mapping[str, Any]) -> Self:
        """Build from nested mappings; missing keys take their defaults.

        Raises
        ------
        ConfigurationError
            For the first key that is unknown, missing or has a wrong value.
        """
        if not isinstance(given, Mapping):
            raise ConfigurationError.of_value("", given, "keys and values")
        fields = {field.name: field for field in msgspec.structs.fields(cls)}
        for name in given:
            if name not in fields:
                shown = name if isinstance(name, str) and name.isprintable() else repr(name)
                raise ConfigurationError(shortened(shown), f"unknown; known are {', '.join(fields)}")
        for name, field in fields.items():
            if field.required and name not in given:
                raise ConfigurationError(name, f"missing; give {allowed(field.type)}")
        values = {}
        for name, value in given.items():
            with _under(name):
                values[name] = _built(fields[name].type, value)
        return cls(**values)

    def to_dict(self) -> dict[str, Any]:
        """Return nested dictionaries that `from_dict` turns back."""
        return msgspec.to_builtins(self)

    def replace(self, **changes: Any) -> Self:
        """Return a copy with single values changed, named ``group__key`` (``learning__alpha=0.1``) or ``alpha=0.1``."""
        groups = self.to_dict()
        names = {field.name for field in msgspec.structs.fields(type(self))}
        for name, value in changes.items():
            group, _, last = name.rpartition("__")
            if not group and name not in names:
                group = _group_with(type(self), name)
            (groups.setdefault(group, {}) if group else groups)[last] = value
        return self.from_dict(groups)


def _nested(kind: type[Group], given: Mapping[str, Any]) -> dict[str, Any]:
    """Put keys of inner groups into their groups."""
    fields = {field.name: field for field in msgspec.structs.fields(kind)}
    keys = {name: value for name, value in given.items() if name in fields}
    for name in given.keys() - fields.keys():
        group = _group_with(kind, name)
        with _under(group):
            inner = _checked(fields[group].type, keys.get(group, fields[group].default))
            keys[group] = inner.replace(**{name: given[name]})
    return keys


def _group_with(kind: type[Group], name: str) -> str:
    """Return the only inner group that has a key; for another name the error lists the groups."""
    inner = {field.name: field.type for field in msgspec.structs.fields(kind) if is_group(field.type)}
    keys = {group: [field.name for field in msgspec.structs.fields(within)] for group, within in inner.items()}
    groups = [group for group, names in keys.items() if name in names]
    if len(groups) == 1:
        return groups[0]
    if groups:
        raise ConfigurationError(name, f"is a key of {' and '.join(groups)}; name one, say {groups[0]}=...")
    known = [f"{group} ({', '.join(names)})" for group, names in keys.items()] or [
        field.name for field in msgspec.structs.fields(kind)
    ]
    raise ConfigurationError(shortened(name), f"unknown; known are {', '.join(known)}")


class Key(NamedTuple):
    """A key of the configuration that has a value, not further keys.

    Attributes
    ----------
    name : str
        Full name; ``<name>`` is a name that the user chooses.
    type : type
        Type with its `msgspec.Meta`.
    default : value or `msgspec.NODEFAULT`
    """

    name: str
    type: Any
    default: Any

    @property
    def meta(self) -> Meta:
        """Description and range."""
        return get_args(self.type)[1]

    @property
    def mark(self) -> str:
        """Where the default comes from."""
        return (self.meta.extra or {}).get("mark", "")


def keys_of(group: type[Group], prefix: str = "") -> Iterator[Key]:
    """Yield every key of a group and of the groups in it."""
    for field in msgspec.structs.fields(group):
        name = f"{prefix}{field.name}"
        if inner := inner_group(field.type):
            yield from keys_of(inner, f"{name}." if is_group(field.type) else f"{name}.<name>.")
        else:
            yield Key(name, field.type, field.default)


def is_group(kind: Any) -> bool:
    """Return whether a type is a group of keys."""
    return isinstance(kind, type) and issubclass(kind, Group)


def inner_group(kind: Any) -> type[Group] | None:
    """Return the group that a type consists of, alone or as the values of a dictionary."""
    plain = _plain(kind)
    inner = get_args(plain)[1] if get_origin(plain) is dict else plain
    return inner if is_group(inner) else None


def allowed(kind: Any) -> str:
    """Return the values that a type allows, in words."""
    if is_group(kind):
        return "keys and values"
    arguments = get_args(kind)
    if get_origin(kind) is Annotated:
        meta = arguments[1]
        if meta.extra and meta.extra["wanted"]:
            return meta.extra["wanted"]
        # numbers as they are written, because a change of ptl.text should not rerun all learning
        bounds = {">": meta.gt, ">=": meta.ge, "<": meta.lt, "<=": meta.le}
        limits = " and ".join(f"{sign} {bound:,}" for sign, bound in bounds.items() if bound is not None)
        return f"{allowed(arguments[0])} {limits}".rstrip()
    if get_origin(kind) is Literal:
        options = [str(option) for option in arguments if option]
        return f"one of {', '.join(options)}" if len(options) > 1 else "".join(options) or "an empty text"
    if get_origin(kind) is list:
        return f"a list, each {allowed(arguments[0])}"
    if get_origin(kind) is tuple:
        return f"a list of {len(arguments)}, each {allowed(arguments[0])}"
    if get_origin(kind) is dict:
        return "names with keys and values"
    if arguments:
        return " or ".join(allowed(argument) for argument in arguments if argument is not type(None))
    return {bool: "true or false", int: "a whole number", float: "a number", str: "text", object: "any value"}[kind]


def _plain(kind: Any) -> Any:
    return get_args(kind)[0] if get_origin(kind) is Annotated else kind


def _built(kind: Any, value: Any) -> Any:
    """Turn the mappings in a value into groups."""
    group = inner_group(kind)
    if group is None:
        return value
    if is_group(kind):
        return group.from_dict(value)
    if not isinstance(value, Mapping):
        raise ConfigurationError.of_value("", value, allowed(kind))
    names, _ = get_args(_plain(kind))
    built = {}
    for name, entry in value.items():
        with _under(_checked(names, name)):
            built[name] = group.from_dict(entry)
    return built


def _checked(kind: Any, value: Any) -> Any:
    """Return a value as its type has it (1 as 1.0 for a number), or refuse it."""
    if is_group(kind) and not isinstance(value, kind):
        raise ConfigurationError.of_value("", value, f"{kind.__name__}(...), or dictionaries to from_dict")
    try:
        if isinstance(value, float) and not math.isfinite(value):
            raise ValueError
        return msgspec.convert(value, kind)
    except (ValueError, OverflowError):  # ValidationError is a ValueError
        raise ConfigurationError.of_value("", value, allowed(kind) + _meant(kind, value)) from None


def _meant(kind: Any, value: Any) -> str:
    """Return a remark on what was probably meant: a number that YAML takes for a text, or the reverse."""
    forms: list[Any] = []
    if isinstance(value, str) and len(value) < 40:
        for text in (value, value.replace(",", ""), value.replace(",", ".")):
            for read in (int, float, lambda digits: int(digits, 0)):
                with suppress(ValueError, OverflowError):
                    number = read(text)
                    forms += [int(number), number] if number == int(number) else [number]
    elif isinstance(value, float) and value.is_integer():
        forms.append(int(value))
    if isinstance(value, bool | int | float | datetime.date):
        with suppress(ValueError):  # as written it may look otherwise: 0x10, 1.50
            msgspec.convert(str(value), kind)
            return " (a text that looks like something else needs quotes)"
    for form in forms:
        with suppress(ValueError, OverflowError):
            if msgspec.convert(form, kind) == form:
                return f" (perhaps {as_written(form)} was meant)"
    return ""


@contextmanager
def _under(name: str) -> Iterator[None]:
    """Put a name in front of the key of an error."""
    try:
        yield
    except ConfigurationError as error:
        raise ConfigurationError(f"{name}.{error.key}" if error.key else name, error.problem) from None


def repeated(items: Collection[str]) -> list[str]:
    """Return the items that occur more than once."""
    return sorted({item for item in items if list(items).count(item) > 1})


def as_written(value: object) -> str:
    """Return a value as a configuration file has it: null, true and .inf instead of Python's None, True and inf."""
    if value is None or isinstance(value, bool):
        return "null" if value is None else str(value).lower()
    if isinstance(value, float) and not math.isfinite(value):
        return {math.inf: ".inf", -math.inf: "-.inf"}.get(value, ".nan")
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(as_written, value))}]"
    if isinstance(value, Mapping):
        return f"{{{', '.join(f'{as_written(name)}: {as_written(entry)}' for name, entry in value.items())}}}"
    if isinstance(value, datetime.date):
        return str(value)
    return repr(value)


def shortened(text: str, length: int = 60) -> str:
    """Return a text, or its beginning if it is long."""
    return text if len(text) <= length else text[: length - 3] + "..."
