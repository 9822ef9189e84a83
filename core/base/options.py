"""How settings are described and checked.

Each field of a dataclass of settings carries an `Option` as metadata: label, help text, bounds
and choices. The Blender properties, the command line and the checks below are all made from it.
"""

from __future__ import annotations

import dataclasses
import math
import numbers
from dataclasses import dataclass, field
from typing import Any, Literal

from .errors import InvalidSettingsError

AUTO = "auto"


@dataclass(frozen=True)
class Choice:
    """One value that an option can take, as shown to the user."""

    value: str
    label: str
    help: str


@dataclass(frozen=True)
class Option:
    """How a setting is shown and checked.

    `kind` is "choice", "count" (a whole number), "number" or "flag". `automatic` says that
    the word "auto" is accepted besides a number; `manual` is the number a front end offers
    first when the user turns "auto" off.
    """

    label: str
    help: str
    kind: Literal["choice", "count", "number", "flag"]
    choices: tuple[Choice, ...] = ()
    minimum: float = -math.inf
    maximum: float = math.inf
    automatic: bool = False
    manual: float = 0.0
    unit: str = ""


def setting(default: Any, **option: Any) -> Any:
    """A field of a dataclass of settings, with its `Option` as metadata.

    Examples
    --------
    >>> from dataclasses import dataclass
    >>> @dataclass(frozen=True)
    ... class Mine:
    ...     count: int = core.setting(3, label="Count", help="How many", kind="count")
    >>> Mine().count, core.options(Mine)["count"].label
    (3, 'Count')
    """
    return field(default=default, metadata={"option": Option(**option)})


def check(settings: Any) -> None:
    """Raise `InvalidSettingsError` if a value does not suit its option.

    Examples
    --------
    >>> core.check(core.Settings(opening=3))
    >>> core.check(core.Settings(opening=-1))
    Traceback (most recent call last):
        ...
    core.base.errors.InvalidSettingsError: ...
    """
    for item in dataclasses.fields(settings):
        _check(item.name, getattr(settings, item.name), item.metadata["option"])


def _check(name: str, value: Any, option: Option) -> None:
    if option.kind == "choice":
        values = [choice.value for choice in option.choices]
        if value not in values:
            raise InvalidSettingsError(f"{name} must be one of {', '.join(values)}, not {value!r}.")
        return
    if option.kind == "flag":
        if not isinstance(value, bool):
            raise InvalidSettingsError(f"{name} must be True or False, not {value!r}.")
        return
    if option.automatic and isinstance(value, str) and value == AUTO:
        return
    number = numbers.Integral if option.kind == "count" else numbers.Real
    if isinstance(value, bool) or not isinstance(value, number) or not _is_finite(name, value):
        wanted = "a whole number" if option.kind == "count" else "a number"
        auto = " or 'auto'" if option.automatic else ""
        raise InvalidSettingsError(f"{name} must be {wanted}{auto}, not {value!r}.")
    if not option.minimum <= float(value) <= option.maximum:
        if math.isinf(option.maximum):
            raise InvalidSettingsError(f"{name} must be {option.minimum:g} or more, not {value:g}.")
        raise InvalidSettingsError(
            f"{name} must lie between {option.minimum:g} and {option.maximum:g}, not {value:g}."
        )


def _is_finite(name: str, value: numbers.Real) -> bool:
    try:
        return math.isfinite(value)
    except OverflowError as error:
        raise InvalidSettingsError(f"{name} has too many digits for a number.") from error
