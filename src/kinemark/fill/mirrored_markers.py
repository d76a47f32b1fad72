"""Left and right: the other side of the body as a second source to learn from.

A person's right side moves, half a cycle later in gait, as the mirror image of the left side does. Markers are paired
by name: the same name but for its first letter, L for R; a prefix up to the last colon is left out. Whatever stands in
the middle is its own partner.
"""

from __future__ import annotations

import numpy as np

from ..data.array_types import Ints

OTHER = {"L": "R", "R": "L", "l": "r", "r": "l"}
REFLECTED = np.array([-1.0, 1.0, 1.0])
"""Any plane serves, as positions are seen from a local frame afterwards; by definition."""


def partners(names: tuple[str, ...]) -> Ints:
    """(M) each marker's partner; all their own where fewer than two pairs are found."""
    short = [name.rsplit(":", 1)[-1] for name in names]
    index = {name: k for k, name in enumerate(short)}
    found = [index.get(OTHER.get(name[:1], name[:1]) + name[1:], k) for k, name in enumerate(short)]
    own = np.arange(len(names))
    return np.array(found) if (np.array(found) != own).sum() >= 4 else own
