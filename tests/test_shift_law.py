"""The origin of the world is arbitrary: a trial 10 km away gives the same answer, 10 km away.

Each public function that takes positions has a case in the modules `shifted_*`: what it gives in a world moved by `by`.
Places must move along, and all else must stay: distances, angles, covariances, pixels, names, choices. Inputs lie on a
grid that such a move does not round, so that what is left is the rounding of the computation; 10 km has ulp 1.9e-9 mm.
"""

import numpy as np
import pytest
import shifted_files  # noqa: F401  its cases
import shifted_motion  # noqa: F401
import shifted_space  # noqa: F401
import shifted_tracks  # noqa: F401
from shifted import CASES, FAR, differences


@pytest.mark.parametrize("name", CASES)
def test_far_away_the_answer_is_the_same(name):
    case, mm, share, _ = CASES[name]
    places, rest = differences(case(np.zeros(3)), case(FAR), FAR)
    assert places <= mm and rest <= share, f"places are off by {places:.2g} mm, the rest by {rest:.2g} of itself"
