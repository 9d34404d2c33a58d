"""Quantities of pint in arguments: they are recognised by their methods, so that pint is not imported."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from . import _gearatlas


def parts(value: Any) -> tuple[Any, str]:
    """The number or array of a quantity, and its unit in the notation of manifests; an empty unit for any other value.

    The unit is that of the quantity if manifests know it, so that `Hz` means revolutions per second as it does there.
    Other units become base units of SI.
    """
    if not hasattr(value, "to_base_units"):
        return value, ""
    unit = _text(value)
    if unit and _gearatlas.conversion(unit, unit) is None:
        value = value.to_base_units()
        unit = _text(value)
    return value.magnitude, unit


def plain(value: Any) -> Any:
    """A value, a list or a mapping with texts such as `"20.0 um"` instead of quantities."""
    if isinstance(value, Mapping):
        return {name: plain(own) for name, own in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(own) for own in value]
    numbers, unit = parts(value)
    if not unit:
        return numbers
    if np.ndim(numbers) > 0:
        return [f"{float(number)!r} {unit}" for number in numbers]
    return f"{float(numbers)!r} {unit}"


def _text(quantity: Any) -> str:
    return f"{quantity.units:~C}".replace("**", "^")
