"""Errors and warnings, with the messages of the command line."""

from __future__ import annotations

from dataclasses import dataclass


class AtlasError(Exception):
    """An error; the message says what is wrong, where, and what to do."""


@dataclass(frozen=True)
class Fault:
    """One error or warning of a manifest."""

    kind: str
    """A short name, such as `wrong-unit`."""
    source: str
    """The file, or `text`, `dict` or `--set`."""
    line: int | None
    """Line, from 1; None if the file cannot be read."""
    column: int | None
    """Column from 1, in characters."""
    key: str
    """The dotted key; empty if it concerns no key."""
    message: str
    """What is wrong, in one sentence."""
    accepted: str | None
    """What would be accepted."""
    nearest: str | None
    """The nearest known key."""
    remedy: str | None
    """What to do."""
    seen_at: str | None
    """The first point of the grid with this fault; None if all points have it."""


class ManifestWarning(UserWarning):
    """A manifest has keys that have no effect, or unusual values; `Manifest.warnings` lists them."""


class ManifestError(AtlasError, ValueError):
    """All errors of a manifest at once; the message is what `atlas check` prints."""

    def __init__(self, text: str, faults: list[dict[str, object]], count: int) -> None:
        super().__init__(text)
        self.faults: list[Fault] = [Fault(**fault) for fault in faults]  # type: ignore[arg-type]
        """The errors and warnings in the order of the text, up to a limit."""
        self.count = count
        """Number of all errors."""
