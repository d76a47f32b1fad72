"""Lamps that images keep as markers are told by never moving while others do, and masks of them are proposed."""

import time
from types import SimpleNamespace

import numpy as np
import pytest

from kinemark.data import Validity
from kinemark.detect import detect_frames, propose
from kinemark.detect.masks import masked
from kinemark.detect.standing import standing_spots
from kinemark.io.masks_toml import read_masks
from kinemark.report.terminal_summary import proposal_text
from kinemark.report.words import advice_of, text_of

SIZE = (160, 240)
LAMPS = np.array([(40.3, 149.0), (200.0, 120.2)])


def film(lamps=LAMPS, *, moves=True, stands=0.0, standing=1, flicker=0.0, frames=24, bits=8, seed=5):
    """Frames (F, H, W) of eight discs that walk by, the first of which stand for a share of the time, and of lamps of
    their size and brightness."""
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[: SIZE[0], : SIZE[1]]
    start = np.column_stack([np.linspace(10, 60, 8), np.linspace(20, 140, 8)])
    images = rng.normal(12, 1.5, (frames, *SIZE))
    for f, image in enumerate(images):
        walked = f * np.array([6.0, 0.5]) * moves
        places = start + walked
        places[:standing] = start[:standing] + np.array([6.0, 0.5]) * max(f - stands * frames, 0) * moves
        light = np.r_[np.full(len(places), 180.0), np.full(len(lamps), 180.0 * (1 + flicker * np.sin(2.1 * f)))]
        for (u, v), level in zip(np.vstack([places, lamps]), light, strict=True):
            image += level * np.clip(4.5 - np.hypot(x - u, y - v), 0, 1)
    white = 2**bits - 1
    grey = np.clip(np.round(images * white / 255), 0, white)
    return grey.astype(np.uint8 if bits == 8 else np.uint16)


def standing(proposal):
    return [found for found in proposal.findings if found.kind == "spots_standing"]


@pytest.mark.parametrize(("bits", "flicker"), [(8, 0.0), (12, 0.0), (16, 0.2)])
def test_lamps_are_named_with_their_places_and_what_to_do(bits, flicker):
    (found,) = standing(propose(film(bits=bits, flicker=flicker)))
    assert found.values["at_list"] == ("(200, 120)", "(40, 149)")
    assert "lamps or reflections" in text_of(found) and "ask them" in advice_of(found)


@pytest.mark.parametrize(
    "images",
    [
        film(LAMPS[:0]),
        film(LAMPS[:0], stands=0.6),
        film(moves=False),
        film(stands=1.0, standing=6),
        film(stands=0.9, standing=8),
        film(frames=4),
    ],
    ids=[
        "no lamps",
        "a foot that stands for a while",
        "nothing moves",
        "only an arm moves",
        "stands and walks off",
        "too few frames",
    ],
)
def test_nothing_is_said_where_nothing_stands_or_nothing_can_be_told(images):
    proposal = propose(images)
    assert not standing(proposal) and not proposal.masks and "masks" not in proposal_text(proposal, "left")


def test_the_proposed_masks_leave_the_lamps_out_and_no_marker(tmp_path):
    images = film()
    proposal = propose(images)
    text = proposal_text(proposal, "cam 1")
    (tmp_path / "masks.toml").write_text(
        "\n".join(line.removeprefix("# ") for line in text[text.index("# [[camera]]") :].splitlines())
    )
    masks = read_masks(tmp_path / "masks.toml")
    assert masks.cameras == ("cam 1",) and masks.sizes.tolist() == [[240, 160]]
    before = detect_frames(images, method=proposal.centroids)
    after = masked(before, masks.pixels("cam 1"))
    left_out = [np.linalg.norm(LAMPS - uv, axis=1).min() < 1 for uv in before.uv]
    assert sum(left_out) == 2 * len(images)
    assert ((after.validity == Validity.MASKED) == left_out).all()


def test_thousands_of_spots_of_clutter_take_no_time():
    """20 000 took 6.5 s, twenty times as long as the rest of the proposal; now 0.04 s."""
    n, rng = 20_000, np.random.default_rng(1)
    left, top = (rng.integers(0, 2000, n) for _ in range(2))
    frame = np.sort(rng.integers(0, 12, n))
    places = {"left": left, "right": left + 2, "top": top + 2048 * frame, "bottom": top + 2 + 2048 * frame}
    groups = SimpleNamespace(area=np.full(n, 9), frame=frame, **places)
    start = time.process_time()
    assert standing_spots(groups, height=2048, width=2048, frames=12) == ()
    assert time.process_time() - start < 2
