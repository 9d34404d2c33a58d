"""Packages that only some methods need."""

from __future__ import annotations

from importlib import import_module
from typing import Any


def optional(module: str, packages: str) -> Any:
    """Imports a module; the error says what to install."""
    try:
        return import_module(module)
    except ImportError as error:
        wanted = module.partition(".")[0]
        raise ImportError(f"{wanted} is not installed; install it with `pip install {packages}`", name=wanted) from error
