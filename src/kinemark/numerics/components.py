"""Parts of a graph that hang together."""

from __future__ import annotations

import numpy as np

from ..data.array_types import Ints


def components(a: Ints, b: Ints, n: int) -> Ints:
    """(n) of each of n nodes the least one that it hangs together with, over K edges between nodes a (K) and b (K).

    SciPy's takes longer to import than most graphs of a tracker take here.
    """
    label = np.arange(n)
    while True:
        low = np.minimum(label[a], label[b])
        lower = label.copy()
        for end in (a, b):
            np.minimum.at(lower, label[end], low)
        lower = lower[lower]
        if (lower == label).all():
            return label
        label = lower
