"""Where the real recordings are that the studies run on."""

import os
import sys
from pathlib import Path

FOLDER = Path(os.environ.get("KINEMARK_DATA", Path(__file__).parents[2] / "shared" / "data"))


def recording(path: str) -> Path:
    """A file or folder of the recordings; ends the study where they are not on this machine."""
    if not (FOLDER / path).exists():
        sys.exit(f"{FOLDER / path} is absent. Name the folder of the recordings in KINEMARK_DATA.")
    return FOLDER / path
