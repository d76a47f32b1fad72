"""Paths and names in commands that a message tells somebody to type."""

from __future__ import annotations

import os
import shlex
import subprocess
from pathlib import Path


def typed(word: Path | str) -> str:
    """A path or name as the terminal takes it for one word: in quotes where it has spaces, brackets and the like."""
    text = str(word)
    return subprocess.list2cmdline([text]) if os.name == "nt" else shlex.quote(text)
