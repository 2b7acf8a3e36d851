"""The meta of a setting, stated once beside its type: `name: Annotated[type, setting(...)]`.

Checks, messages, the docstring of `Settings`, `mossar settings` and the JSON Schema read it from there.
"""

import textwrap
from typing import Any, Literal, get_args, get_origin, get_type_hints

import msgspec

LINE_WIDTH = 120  # characters of a line of a docstring


def setting(
    text: str,
    effect: str,
    *,
    unit: str = "",
    low: float | None = None,
    high: float | None = None,
    legal: str = "",
) -> msgspec.Meta:
    """Return the annotation of a setting.

    Args:
        text: Its meaning; for the docstring and the schema.
        effect: The effect of a larger value, or of each choice.
        unit: Of its value; empty where it has none.
        low: Smallest legal number.
        high: Largest legal number.
        legal: Legal values, if neither limits nor choices state them.
    """
    extra = {"unit": unit, "effect": effect, "limits": None if low is None else (low, high), "legal": legal}
    # msgspec has none of its own for unions.
    bounds = {} if low is None else {"minimum": low, "maximum": high}
    return msgspec.Meta(description=text, extra_json_schema=bounds, extra=extra)


class SettingMeta(msgspec.Struct, frozen=True):
    """The description of a setting.

    Args:
        text: Its meaning.
        effect: The effect of a larger value, or of each choice.
        unit: Of its value; empty where it has none.
        limits: Smallest and largest legal number; None if it is no number.
        choices: Legal words.
        kinds: Types of its values besides words among `choices`; a group of values has none.
        optional: Whether None, the value of the level's bundle, is legal.
        written: Text of the legal values for users.
    """

    text: str
    effect: str
    unit: str
    limits: tuple[float, float] | None
    choices: tuple[str, ...]
    kinds: tuple[type, ...]
    optional: bool
    written: str

    def allows(self, value: object) -> bool:
        """Return whether a value is legal."""
        if value is None:
            return self.optional
        if isinstance(value, bool):
            return bool in self.kinds
        if isinstance(value, str):
            return value in self.choices if self.choices else str in self.kinds
        if self.limits is None:
            return not self.kinds  # a group, which is checked by its own rule
        low, high = self.limits
        return isinstance(value, int if self.is_whole else int | float) and low <= value <= high

    @property
    def is_whole(self) -> bool:
        """Whether its values are whole numbers."""
        return int in self.kinds

    @property
    def rule(self) -> str:
        """The rule of a value, as in `must lie between 1 and 45`."""
        if self.limits is not None and not self.choices:
            low, high = self.limits
            return f"{'be a whole number' if self.is_whole else 'lie'} between {low:g} and {high:g}"
        if self.choices and self.limits is None:
            return f"be one of {', '.join(self.choices)}"
        return "be true or false" if self.kinds == (bool,) else f"be {self.written}"


def metas_of(record: type[msgspec.Struct]) -> dict[str, SettingMeta]:
    """Return the description of each field of a record."""
    hints = get_type_hints(record, include_extras=True)
    return {name: _meta_of(hints[name]) for name in record.__struct_fields__}


def _meta_of(hint: Any) -> SettingMeta:
    kind, meta = get_args(hint)
    members = get_args(kind) if get_origin(kind) is not Literal and get_args(kind) else (kind,)
    choices = tuple(word for one in members if get_origin(one) is Literal for word in get_args(one))
    kinds = tuple(one for one in members if one in (bool, int, float, str))
    extra = meta.extra
    limits = extra["limits"]
    written = extra["legal"] or ", ".join(choices)
    if not written and limits is not None:
        written = f"{limits[0]:g} to {limits[1]:g}"
    return SettingMeta(
        text=meta.description,
        effect=extra["effect"],
        unit=extra["unit"],
        limits=limits,
        choices=choices,
        kinds=kinds,
        optional=type(None) in members,
        written=written or "true, false",
    )


def document(record: type[msgspec.Struct], metas: dict[str, SettingMeta]) -> None:
    """Write the fields of a record into its docstring, in place of the line `FIELDS`."""
    lines = []
    for name, meta in metas.items():
        first, stop, rest = meta.text.partition(". ")
        text = f"{name}: {first}{f', {meta.unit}' if meta.unit else ''}{stop}{rest}."
        lines += textwrap.wrap(text, LINE_WIDTH, initial_indent=" " * 8, subsequent_indent=" " * 12)
    record.__doc__ = (record.__doc__ or "").replace("        FIELDS", "\n".join(lines))
