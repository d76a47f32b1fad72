"""A second generator of scenes for tracking, which shares no code with `kinemark.synth`.

`scene(seed)` draws what a scene is like and `make(scene)` makes it: stick bodies that walk, run, jump or crawl
(`bodies`), cameras in seven placements (`placements`), their images with noise, occlusion, merging, drop-outs and false
ones (`imaging`), and a calibration file that may be off. `tally` compares tracks with the truth. Only the records of
`kinemark.data` are used.

Seeds DEVELOPMENT are for work on the tracker. Seeds FINAL are for the end: nobody tunes on them.
"""

from .scene import DEVELOPMENT, FINAL, Made, Scene, make, scene
from .tally import Tally, tally

__all__ = ["DEVELOPMENT", "FINAL", "Made", "Scene", "Tally", "make", "scene", "tally"]
