"""Recordings of a session whose every image says the number of its frame, too darkly to be taken for a marker.

Twelve bars along the upper edge are the bits of the number. The videos are H.264 in groups of frames, in several
containers, as a camera's own program may leave them.
"""

from fractions import Fraction

import numpy as np

from kinemark.io.images import open_images
from support.numbered_video import BITS, write_numbered

LEVEL, ROWS = 45, 0.06  # grey level of a bit that is set; share of the image's height
KINDS = (
    ("avi", 30),
    ("mp4", 40),
    ("mkv", 60),
    ("avi", 12),
    ("ts", 25),
)  # container, frames from key frame to key frame
READ = """
() => [...document.querySelectorAll("[aria-label=Cameras] canvas")].map((canvas) => {
  const tile = canvas.parentElement, name = canvas.getAttribute("aria-label").slice(9);
  const ratio = canvas.width / tile.clientWidth, [w, h] = SIZES[name];
  const scale = Math.min(tile.clientWidth / w, tile.clientHeight / h) * ratio;
  const x = canvas.width / 2 - w / 2 * scale, y = canvas.height / 2 - h / 2 * scale;
  const row = canvas.getContext("2d").getImageData(0, Math.round(y + ROWS / 2 * h * scale), canvas.width, 1).data;
  let number = 0;
  const level = (b) => row[4 * Math.round(x + (b + 0.5) / BITS * w * scale)];
  for (let b = 0; b < BITS; b++) if (level(b) > LEVEL / 2) number += 1 << b;
  return number;
})
"""


def burn(folder, trial="walk01", rate=50):
    """Draw the numbers into the videos of a trial, from 1, and write them as other programs would."""
    for k, path in enumerate(sorted((folder / trial).glob("*.mkv"))):
        images = np.stack(list(open_images(path).frames()))
        h, w = images.shape[1:]
        bit = np.arange(w) * BITS // w
        for n, image in enumerate(images, 1):
            image[: round(ROWS * h)] = np.where((n >> bit) & 1, LEVEL, 0)
        ending, group = KINDS[k % len(KINDS)]
        other = write_numbered(
            path.with_suffix(f".{ending}"), len(images), rate=Fraction(rate), group=group,
            image=lambda n, images=images: images[n], options={"crf": "8", "preset": "veryfast"},
        )  # fmt: skip
        other.replace(path)


def numbers_shown(page, cameras):
    """The number in each camera's tile; `cameras`: name → width and height, px."""
    sizes = {name: list(map(int, size)) for name, size in cameras.items()}
    script = READ.replace("SIZES", str(sizes)).replace("ROWS", str(ROWS)).replace("BITS", str(BITS))
    return page.evaluate(script.replace("LEVEL", str(LEVEL)))
