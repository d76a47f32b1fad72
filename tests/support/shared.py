"""Where the real recordings are, or why a test that needs them is skipped."""

import os
from pathlib import Path

import pytest

ROOT = Path(os.environ.get("KINEMARK_DATA", Path(__file__).parents[3] / "shared" / "data"))


def shared_data(path: str) -> Path:
    """A file or folder of the real recordings; skips the test where they are not on this machine."""
    if not (ROOT / path).exists():
        pytest.skip(f"needs the real recordings: {ROOT / path} is absent (KINEMARK_DATA names another folder)")
    return ROOT / path
