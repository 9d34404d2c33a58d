"""HTML tables for notebooks, and titles of columns."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape
from typing import Any


def html_table(head: Sequence[str], rows: Iterable[Sequence[Any]], note: str) -> str:
    """A table with a line below it."""
    heads = "".join(f"<th>{escape(name)}</th>" for name in head)
    body = "".join(f"<tr>{''.join(f'<td>{escape(_text(cell))}</td>' for cell in row)}</tr>" for row in rows)
    return f"<table><thead><tr>{heads}</tr></thead><tbody>{body}</tbody></table><p>{escape(note)}</p>"


def titled(name: str, unit: str) -> str:
    """`speed [rad/s]`; no unit if there is none."""
    return name if unit in ("", "1") else f"{name} [{unit}]"


def _text(cell: Any) -> str:
    if isinstance(cell, list):
        return ", ".join(map(_text, cell))
    if isinstance(cell, float):
        return f"{cell:.6g}"
    return "" if cell is None else str(cell)
