"""What can go wrong, said in sentences: the same as those of the command line."""

from __future__ import annotations

from dataclasses import dataclass


class AtlasError(Exception):
    """Something was refused; the message says what, where, and what to do."""


@dataclass(frozen=True)
class Fault:
    """One fault of a manifest, an error or a warning."""

    kind: str
    """A short name, such as `wrong-unit`."""
    source: str
    """The file, or `text`, `dict` or `--set`."""
    line: int | None
    """Line from 1; none where a file cannot be read."""
    column: int | None
    """Column from 1, in characters."""
    key: str
    """The dotted key; empty where no key is concerned."""
    message: str
    """What is wrong, one sentence."""
    accepted: str | None
    """What would be accepted."""
    nearest: str | None
    """The nearest known key."""
    remedy: str | None
    """What to do."""
    seen_at: str | None
    """The point of the grid at which it shows, where it is not a fault of every point."""


class ManifestWarning(UserWarning):
    """A manifest has keys without effect, or describes a drive that is unusual; `Manifest.warnings` lists them."""


class ManifestError(AtlasError, ValueError):
    """All faults of a manifest at once; the message is what `atlas check` prints."""

    def __init__(self, text: str, faults: list[dict[str, object]], count: int) -> None:
        super().__init__(text)
        self.faults: list[Fault] = [Fault(**fault) for fault in faults]  # type: ignore[arg-type]
        """The faults in the order of the text, no more of them than anybody reads."""
        self.count = count
        """How many there are."""
