"""Starts the program `atlas` that lies in this package."""

import os
import sys
from pathlib import Path

PROGRAM = Path(__file__).parent / "bin" / "atlas"


def main() -> None:
    """Becomes the program, with the arguments of this process."""
    if not PROGRAM.exists():
        sys.exit(
            "error: this package was built without the program `atlas`; install a wheel of scripts/release, or run "
            "`cargo install --locked --path .` in the sources"
        )
    os.execv(PROGRAM, sys.argv)


if __name__ == "__main__":
    main()
