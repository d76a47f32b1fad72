"""The default tracker on scenes with impacts, `tests/support/scenes/impacts.py`.

    python benchmarks/impacts.py 0-39              a line a scene, and the table

A table as that of `benchmarks/tracking_scenes.py`: an impact that ends tracks shows in the pieces a marker has.
"""

from __future__ import annotations

import argparse
import time
from collections import defaultdict

from tracking_scenes import HEAD, numbers, row

from kinemark.track.simultaneous import track_with_decisions
from support.scenes import Tally, tally
from support.scenes.impacts import impact_scene


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("seeds", nargs="*", default=["0-39"], help="such as 3 or 40-49")
    groups: dict[str, list[tuple[Tally, float]]] = defaultdict(list)
    print(HEAD)
    for seed in numbers(parser.parse_args().seeds):
        made, begin = impact_scene(seed), time.process_time()
        tracks, decisions = track_with_decisions(made.detections, made.rig)
        seconds, t = time.process_time() - begin, tally(made, tracks, decisions)
        print(row(str(made.scene), t, seconds), flush=True)
        for name in (f"{made.scene.cameras} cameras", f"{made.scene.rate:g} Hz", made.scene.motion, "all"):
            groups[name].append((t, seconds))
    print("\n" + HEAD)
    for name, scenes in sorted(groups.items()):
        total = scenes[0][0]
        for t, _ in scenes[1:]:
            total += t
        print(row(f"{name}: {len(scenes)} scenes", total, sum(seconds for _, seconds in scenes)))


if __name__ == "__main__":
    main()
