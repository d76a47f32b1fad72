"""Images of a late camera, in the frames of the others."""

from __future__ import annotations

import numpy as np

from kinemark.numerics.later_frames import in_later_frames


def test_an_image_comes_as_many_frames_later_as_its_camera_is_late() -> None:
    uv = np.arange(8.0).reshape(4, 2)
    late, early = in_later_frames(uv, 1), in_later_frames(uv, -2)
    np.testing.assert_array_equal(late, [[np.nan, np.nan], [0, 1], [2, 3], [4, 5]])
    np.testing.assert_array_equal(early, [[4, 5], [6, 7], [np.nan, np.nan], [np.nan, np.nan]])


def test_a_camera_may_be_late_by_more_from_a_frame_on_and_rows_may_be_numbers() -> None:
    found = in_later_frames(np.arange(5), np.array([0, 0, 1, 1, 9]), missing=-1)
    np.testing.assert_array_equal(found, [0, 1, 1, 2, -1])
