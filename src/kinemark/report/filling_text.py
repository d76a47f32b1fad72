"""What became of a trial's gaps, as a few lines for the terminal."""

from __future__ import annotations

from typing import Any

from .words import TAGS, frames_text, headline_of, open_gap_text, sentences_of, text_of


def filling_summary(figures: dict[str, Any]) -> str:
    """The figures as a few lines of text, with what needs attention and the gaps that stayed open."""
    names = ", ".join(f"{name} {n}" for name, n in figures["by_method"].items())
    lines = [f"{headline_of(figures['verdict'])}{': ' + names if names else ''}", *sentences_of(figures["verdict"])]
    lines += [f"  {TAGS[found['severity']]}: {text_of(found)}" for found in figures["findings"]]
    for gap in figures["list"]:
        if not gap["method"]:
            frames = f"frame{'' if gap['frames'] == 1 else 's'} {frames_text(gap)}"
            lines.append(f"  open: {gap['marker']}, {frames}: {open_gap_text(gap, figures['limit_mm'])}")
    return "\n".join(lines)
