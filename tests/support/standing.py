"""A subject with the fifteen markers of the lower limbs, near standing."""

import numpy as np

from kinemark.data.subject_measures import LETTER, SIDES, TO_THE_LEFT


def walker(seed=0, n=12):
    """(n, 3) mm of each marker: a random posture near standing in each frame, of markers on rigid segments."""
    rng = np.random.default_rng(seed)
    at = {"LASI": (100, 120, 950), "RASI": (100, -120, 950), "SACR": (-80, 0, 970)}
    for side in SIDES:
        s, y = LETTER[side], TO_THE_LEFT[side]
        at |= {s + "THI": (20, 170 * y, 700), s + "KNE": (10, 140 * y, 480), s + "TIB": (0, 150 * y, 300),
               s + "ANK": (-10, 130 * y, 90), s + "HEE": (-70, 100 * y, 40), s + "TOE": (130, 120 * y, 35)}  # fmt: skip
    swing = np.cumsum(rng.normal(0, 6, (n, len(at), 3)), 0)
    return {name: np.array(xyz, float) + swing[:, k] for k, (name, xyz) in enumerate(at.items())}
