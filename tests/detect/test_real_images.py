"""Detection on real images: every dot of the two-level target, and no worse than its published fit."""

import av
import numpy as np
import pytest

from kinemark.detect import Centroids, detect_frames
from kinemark.geometry import fit_dlt, from_dlt
from support.shared import shared_data

CORNERS = np.array([[-67.5, 30], [67.5, 30], [-67.5, -30], [67.5, -30]])


def grey(path):
    with av.open(str(path)) as container:
        return next(container.decode(video=0)).to_ndarray(format="gray")


def homography(xy, uv):
    """(3, 3) the plane's map that takes four points xy to uv, flattened DLT."""
    rows = [
        row
        for (x, y), (u, v) in zip(xy, uv, strict=True)
        for row in ([x, y, 1, 0, 0, 0, -u * x, -u * y, -u], [0, 0, 0, x, y, 1, -v * x, -v * y, -v])
    ]
    return np.linalg.svd(np.array(rows))[2][-1].reshape(3, 3)


def mapped(P, points):
    h = np.column_stack([points, np.ones(len(points))]) @ P.T
    return h[:, :2] / h[:, 2:]


@pytest.mark.parametrize(("camera", "side", "first"), [(1, 1, 0), (2, 2, 0), (3, 2, 0), (4, 1, 4)])
def test_all_95_dots_are_found_where_a_camera_puts_them(camera, side, first):
    folder = shared_data("cameras/dot_target_4cam")
    dots = np.loadtxt(folder / "cal" / f"target_on_a_side{side}.txt")[:, 1:]
    found = detect_frames(grey(folder / "cal" / f"cam{camera}.tif")[None], method=Centroids(min_area=50))
    uv = found.uv[found.validity == 0]
    corners = np.loadtxt(folder / "man_ori.dat")[first : first + 4]  # clicked by hand
    expected = mapped(homography(CORNERS, corners), dots[:, :2])
    for reach in (15, 15, 15, 3, 3, 3):
        distance = np.linalg.norm(expected[:, None] - uv, axis=2)
        near, close = distance.argmin(1), distance.min(1) < reach
        expected = mapped(from_dlt(fit_dlt(dots[close], uv[near[close]])), dots)
    assert close.all() and len(set(near)) == 95
    assert np.sqrt(np.mean(distance.min(1) ** 2)) < 0.15
