"""Images in memory as a recording of one camera."""

import numpy as np


class Film:
    """Images (n, H, W): whole frames or, `interlaced`, fields, of which every second one lies half a line lower."""

    def __init__(self, images, *, interlaced=False, announced=None):
        self.images, self.interlaced = np.asarray(images), interlaced
        self.n_frames = len(images) if announced is None else announced

    def batches(self, n):
        return (self.images[k : k + n] for k in range(0, len(self.images), n))

    def v_offset(self, f):
        return 0.5 * (f % 2) if self.interlaced else 0.0
