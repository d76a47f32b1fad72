"""How large the page of a trial is, how long it takes to load in a browser, and how long it is to scroll.

    python benchmarks/pages.py [TRACKS FRAMES]

1 000 tracks of 20 000 frames where nothing else is asked for, eight cameras, pictures of noise, names of 40 letters.
Chromium, where it is installed, measures on a screen of 1366 × 768 how long it takes until the page is there, and
until all its drawings are. Times are of this machine and no metrics; the size of the page is one.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

from metrics import Metric

from kinemark.report import write_report

sys.path.append(str(Path(__file__).parents[1] / "tests"))
from support.browser import NAMES, opened
from support.many_tracks import long_trial

SHORT = (200, 2000)
"""Tracks and frames for the comparison with the baseline, which should not take minutes."""


def written(folder: Path, tracks: int, frames: int) -> Path:
    """The report of such a trial, which shares its drawing library."""
    trial = long_trial(tracks, frames, name="a_marker_with_a_name_of_40_letters__{}")
    write_report(folder / "trial/report.html", **trial, assets=folder / "assets")
    return folder / "trial/report.html"


def loaded(page: Path) -> dict[str, float]:
    """s until the page is there, s until all is drawn, and its height in px."""
    with opened(page, drawn=False) as tab:
        there = tab.ask("performance.getEntriesByType('navigation')[0].loadEventEnd") / 1000
        height = tab.ask("document.documentElement.scrollHeight")
        tab.until("!!document.documentElement.dataset.drawn")
        return {"load, s": there, "all drawn, s": tab.ask("performance.now()") / 1000, "height, px": height}


def metrics() -> list[Metric]:
    """The size of a page of many tracks."""
    with tempfile.TemporaryDirectory() as folder:
        size = written(Path(folder), *SHORT).stat().st_size / 1e6
    return [Metric("size of a report of 200 tracks", size, "MB", "less", relative=0.05)]


def main() -> None:
    """Print the table."""
    tracks, frames = map(int, sys.argv[1:3]) if len(sys.argv) > 2 else (1000, 20_000)
    with tempfile.TemporaryDirectory() as folder:
        page = written(Path(folder), tracks, frames)
        print(f"{tracks} tracks, {frames} frames: {page.stat().st_size / 1e6:.2f} MB")
        try:
            figures = loaded(page)
        except BaseException as error:  # pytest's Skipped, which is no Exception
            if type(error).__name__ != "Skipped":
                raise
            print(f"no browser: none of {', '.join(NAMES)}")
            return
        print(", ".join(f"{name} {value:.2f}" for name, value in figures.items()))


if __name__ == "__main__":
    main()
