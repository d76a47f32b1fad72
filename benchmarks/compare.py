"""All benchmarks in a short form, against the committed baseline: `baseline.toml`.

    python benchmarks/compare.py [name …]            run and compare; fails where a metric is worse than its tolerance
    python benchmarks/compare.py --update [name …]   run and write the baseline anew
    python benchmarks/compare.py --json FILE         and write what was measured

Each benchmark has a function `metrics`, which is its main program on fewer cases. Seeds are fixed, so errors and counts
are the same on every machine but for rounding; speeds are ratios of two times in one run, and have wide tolerances.
"""

from __future__ import annotations

import argparse
import datetime
import json
import os
import platform
import sys
import tomllib
from collections.abc import Callable
from pathlib import Path

import bundle
import detection
import detection_speed
import gaps
import labelling
import pages
import recording
import startup
import studio_browser
import tomlkit
import tracking
import tracking_scenes
from metrics import Metric, is_worse

import studio
from kinemark.version import __version__

BASELINE = Path(__file__).with_name("baseline.toml")
SUITE: dict[str, Callable[[], list[Metric]]] = {
    "detection": detection.metrics,
    "detection_speed": detection_speed.metrics,
    "recording": recording.metrics,
    "tracking": tracking.metrics,
    "tracking_scenes": tracking_scenes.metrics,
    "bundle": bundle.metrics,
    "gaps": gaps.metrics,
    "labelling": labelling.metrics,
    "startup": startup.metrics,
    "pages": pages.metrics,
    "studio": studio.metrics,
    "studio_browser": studio_browser.metrics,
}
Entries = dict[str, dict[str, dict[str, str | float]]]


def baseline() -> Entries:
    """benchmark → metric → value, unit, better, relative, absolute."""
    return tomllib.loads(BASELINE.read_text(encoding="utf-8")) if BASELINE.is_file() else {}


def as_toml(entries: Entries) -> str:
    """A table a metric."""
    document = tomlkit.document()
    document.add(
        tomlkit.comment("Written by `python benchmarks/compare.py --update`; metrics.py says what fields mean.")
    )
    document.add(tomlkit.comment(made()))
    document.update(entries)
    return tomlkit.dumps(document)


def made() -> str:
    """When, by which version, and on what kind of machine."""
    machine = (
        f"{os.cpu_count()} processors {platform.machine()}, {platform.system()}, Python {platform.python_version()}"
    )
    return f"{datetime.date.today().isoformat()}, Kinemark {__version__}, {machine}; seeds 0 to 12, in the programs"


def line(metric: Metric, before: float | None) -> tuple[str, bool]:
    """A row of the table, and whether the metric is worse."""
    worse = before is not None and is_worse(metric, before)
    was = "new" if before is None else f"{before:.4g}"
    verdict = "WORSE" if worse else ""
    return f"  {metric.name:44s}{metric.value:12.4g} {metric.unit:12s}{was:>12s}  {metric.better:5s} {verdict}", worse


def main() -> None:
    """Do what the arguments say."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", help=f"of {', '.join(SUITE)}; all where none is given")
    parser.add_argument("--update", action="store_true")
    parser.add_argument("--json", type=Path)
    asked = parser.parse_args()
    known, measured, worse = baseline(), {}, 0
    for name in asked.names or SUITE:
        print(f"{name}{'measured':>50s} {'':12s}{'baseline':>12s}  better", flush=True)
        found = SUITE[name]()
        measured[name] = {metric.name: metric.entry for metric in found}
        for metric in found:
            before = known.get(name, {}).get(metric.name)
            row, bad = line(metric, None if before is None else float(before["value"]))
            worse += bad
            print(row, flush=True)
        for gone in known.get(name, {}).keys() - measured[name].keys():
            print(f"  {gone}: in the baseline, not measured")
            worse += 1
    if asked.json:
        asked.json.write_text(json.dumps(measured, indent=1), encoding="utf-8")
    if asked.update:
        BASELINE.write_text(as_toml(known | measured), encoding="utf-8")
    elif worse:
        sys.exit(f"{worse} metrics are worse. If that is meant, run with --update, and say why in the changelog.")


if __name__ == "__main__":
    main()
