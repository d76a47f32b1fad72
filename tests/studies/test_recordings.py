"""The studies on real recordings still print the figures that the documentation quotes."""

import re

import pytest

from support.shared import shared_data
from support.studies import figures, printed

GAIT = ("recall", "median", "p95", "swaps", "pieces", "per_track", "extra", "strangers", "chance", "markers", "seconds")


@pytest.mark.nightly
def test_a_clinical_gait_trial():
    shared_data("cameras/gait9_bts/gait9.tdf")
    text = printed("gait_trial")
    exact, division = figures(text, "the exact inverse (Kinemark)"), figures(text, "one division (the reference)")
    assert all(a < b for a, b in zip(exact[-4:], division[-4:], strict=True))
    ours, theirs = (part.split("\n\n")[0] for part in text.split("Against the reference tracks, through ")[1:])
    found = {
        name: dict(zip(GAIT, figures(theirs, name)[-len(GAIT) :], strict=True))
        for name in ("simultaneous", "epipolar_triplets, extrapolation_ladder", "kiss_triplets, kiss_tracking")
    }
    ladder = found["epipolar_triplets, extrapolation_ladder"]
    assert ladder["recall"] >= 98 and ladder["median"] <= 0.2 and ladder["swaps"] == 0 and ladder["pieces"] < 1.2
    assert found["simultaneous"]["recall"] > 97.5 and found["simultaneous"]["pieces"] < 1.2
    stands = text.split("so many are found, %:")[1].split("Who is right")[0]
    assert figures(stands, "simultaneous")[0] > 99.3 and figures(stands, "epipolar_triplets")[0] > 99
    for judge in ("images", "path", "distances"):  # of the points that differ most, ours fit better
        said = re.search(rf"simultaneous +10 to 30 mm, {judge}.* ours +(\d+) %, the reference +(\d+) %", text)
        assert said and int(said[1]) > 1.5 * int(said[2]), judge
    assert found["kiss_triplets, kiss_tracking"]["recall"] > 90
    for name, row in found.items():
        assert row["chance"] <= 0.2 and row["extra"] - row["markers"] <= 0.2
        assert row["recall"] > figures(ours, name)[-len(GAIT)]


@pytest.mark.nightly
def test_infrared_footage(tmp_path):
    shared_data("cameras/ir_4cam_footage")
    text = printed("infrared_footage", tmp_path / "session")
    assert figures(text, "frames reconstructed, with 12 or more of the 15 LEDs in place:")[0] > 900
    assert figures(text, "0.0 to   0.0:")[0] < 2.53


KNOWN = {
    "0.35  1.68": [1.20],
    "0.86  0.33": [0.19, 0.31, 0.34],
    "mean difference from the stored coordinates, as digitised:": [5.40],
    "mean difference from the stored coordinates, shifted by the fixed marks:": [1.44],
    "wand of 0.66 m: median": [0.6602],
    "thrown object: |g| =": [10.03],
}


@pytest.mark.nightly
def test_dlt_files():
    shared_data("cameras/dltdv_thermal_3cam")
    text = printed("dlt_files")
    for row, expected in KNOWN.items():
        assert figures(text, row)[: len(expected)] == pytest.approx(expected, abs=0.02), row
    assert figures(text, "largest difference from the stored coordinates:")[0] < 1e-6
