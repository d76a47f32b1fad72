"""Writes src/colours.css: the studio's colours of data, from those that the reports share. `python3 ui/colours.py`."""

from __future__ import annotations

from pathlib import Path

from kinemark.report.theme import FAINT, GRID, HUES, INK, PAPER, STATES

TARGET = Path(__file__).parent / "src" / "colours.css"


def colours_css() -> str:
    """The colours as custom properties: of origins, of hues in their order, and of light pages."""
    lines = [f"  --origin-{name}: {colour.lower()};" for name, colour in STATES.items()]
    lines += [f"  --hue-{i}: {colour.lower()};" for i, colour in enumerate(HUES)]
    page = {"ink": INK, "faint": FAINT, "grid": GRID, "paper": PAPER}
    lines += [f"  --page-{name}: {colour.lower()};" for name, colour in page.items()]
    return "\n".join(["/* Written by ui/colours.py from kinemark/report/theme.py. */", ":root {", *lines, "}", ""])


if __name__ == "__main__":
    TARGET.write_text(colours_css(), encoding="utf-8")
