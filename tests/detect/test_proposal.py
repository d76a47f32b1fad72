"""Parameters that images propose: detection with them finds what is there, and images that look wrong are said to."""

import importlib
import tomllib
from dataclasses import asdict, replace

import numpy as np
import pytest
from scipy import ndimage

from kinemark.data import KinemarkError, Rig, Validity, make_finding
from kinemark.detect import KissScanning, detect_frames, propose
from kinemark.engine.detection.proposals import propose_detection
from kinemark.engine.settings import method_of
from kinemark.io.images import open_images, write_png
from kinemark.io.rig_toml import write_rig_toml
from kinemark.report.terminal_summary import proposal_text
from kinemark.report.words import text_of
from support.laboratory import camera
from support.shared import shared_data
from support.studies import STUDIES

SIZE = (240, 320)


def scene(seed, *, diameters=(7, 12), peak=180.0, ground=15.0, noise=3.0, markers=25, strobes=0, specks=0, frames=4):
    """(F, H, W) grey levels as floats and the number of markers: discs apart from each other, with rims a pixel wide.

    Strobes have 50 px, specks are bright squares of 3 px.
    """
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[: SIZE[0], : SIZE[1]]
    kinds = [("marker", markers), ("strobe", strobes), ("speck", specks)]
    images = np.full((frames, *SIZE), float(ground))
    for image in images:
        taken = np.zeros((0, 3))
        for kind, number in kinds:
            for _ in range(number):
                d = 50.0 if kind == "strobe" else 3.0 if kind == "speck" else rng.uniform(*diameters)
                while True:
                    u, v = rng.uniform((d, d), (SIZE[1] - d, SIZE[0] - d))
                    if (np.hypot(taken[:, 0] - u, taken[:, 1] - v) > taken[:, 2] + d / 2 + 5).all():
                        break
                taken = np.vstack([taken, [u, v, d / 2]])
                if kind == "speck":
                    image[int(v) : int(v) + 3, int(u) : int(u) + 3] = ground + peak
                else:
                    image += peak * np.clip(d / 2 + 0.5 - np.hypot(x - u, y - v), 0, 1)
    return images + rng.normal(0, noise, images.shape)


def grey(images, dtype=np.uint8):
    return np.clip(np.round(images), 0, np.iinfo(dtype).max).astype(dtype)


def methods(proposal):
    return proposal.scanning, proposal.centroids


@pytest.mark.parametrize(
    ("light", "sizes"),
    [
        ({"peak": 180}, (7, 12)),
        ({"peak": 60, "noise": 2.0}, (7, 12)),
        ({"peak": 25, "ground": 40, "noise": 1.5}, (9, 12)),
        ({"peak": 180, "ground": 60, "noise": 8.0}, (10, 20)),
        ({"peak": 230, "noise": 0.0, "ground": 0}, (5, 6)),
    ],
)
def test_with_the_proposed_parameters_all_markers_are_found_and_nothing_else(light, sizes):
    images = grey(scene(1, diameters=sizes, **light))
    proposal = propose(images)
    for method in (*methods(proposal), proposal.nearest):
        found = detect_frames(images, method=method)
        if method is not proposal.nearest:  # it has no limits of size, and divides the larger ones of unequal markers
            assert found.counts.tolist() == [25] * 4 and not found.validity.any() and not found.merged.any()
        assert abs(len(found.uv) - 100) <= 30
    assert proposal.sizes.least >= 0.6 * sizes[0] ** 2 and proposal.sizes.greatest <= 0.95 * (sizes[1] + 1) ** 2
    assert sizes[0] - 1 <= proposal.sizes.width <= sizes[1] + 1


def test_strobes_and_specks_fall_outside_of_the_limits():
    images = grey(scene(2, diameters=(9, 12), strobes=2, specks=4))
    proposal = propose(images)
    assert (proposal.sizes.strobes, proposal.sizes.specks) == (2, 4) and proposal.findings == ()
    for method in methods(proposal):
        found = detect_frames(images, method=method)
        assert np.bincount(found.validity, minlength=3)[:3].tolist() == [100, 16, 8]
        assert (found.area[found.validity == Validity.TOO_LARGE] > 1500).all()


def placed(*discs, ground=15.0, noise=2.0):
    """(1, H, W) discs (u, v, diameter, peak)."""
    y, x = np.mgrid[: SIZE[0], : SIZE[1]]
    image = np.full(SIZE, ground) + np.random.default_rng(0).normal(0, noise, SIZE)
    for u, v, d, peak in discs:
        image += peak * np.clip(d / 2 + 0.5 - np.hypot(x - u, y - v), 0, 1)
    return grey(image)[None]


def test_near_and_far_markers_are_markers_and_a_single_strobe_is_none():
    near = [(20 + 25 * k, 40, 12, 180) for k in range(10)]
    far = [(20 + 20 * k, 100, 4, 180) for k in range(6)]
    spread = [(20 + 25 * k, 40, 6 + k, 180) for k in range(8)]
    for markers in (near + far, spread):
        proposal = propose(placed(*markers, (200, 170, 50, 180)))
        found = detect_frames(placed(*markers, (200, 170, 50, 180)), method=proposal.scanning)
        assert np.bincount(found.validity).tolist() == [len(markers), 0, 1]
        assert proposal.sizes.strobes == 1 and proposal.sizes.specks == 0


def test_a_light_of_the_size_of_two_markers_does_not_make_two_markers_invalid():
    sizes = propose(placed(*((20 + 25 * k, 40, 10, 180) for k in range(10)), (200, 170, 14.5, 180))).sizes
    assert sizes.strobes == 1 and sizes.high >= 2 * sizes.greatest


def test_bright_strobes_do_not_hide_dim_markers():
    markers = [(20 + 25 * k, 40, 9, 80) for k in range(10)]
    image = placed(*markers, (60, 150, 50, 240), (200, 170, 60, 240))
    found = detect_frames(image, method=propose(image).scanning)
    assert np.bincount(found.validity).tolist() == [10, 0, 2]


def test_small_markers_have_more_room_for_their_rough_ratios():
    ratios = [propose(grey(scene(13, diameters=(d, d + 0.3), markers=12))).scanning.max_ratio for d in (5, 8, 18)]
    assert ratios[0] > 1.6 > ratios[1] > ratios[2] >= 1.43


def test_two_markers_on_each_other_are_no_strobe():
    lone, double = scene(3, diameters=(9, 9.5)), np.full(SIZE, 15.0)
    y, x = np.mgrid[: SIZE[0], : SIZE[1]]
    for u in (100, 107):
        double = np.maximum(double, 15 + 180 * np.clip(5 - np.hypot(x - u, y - 100), 0, 1))
    proposal = propose(grey(lone))
    for method in methods(proposal):
        assert detect_frames(grey(double)[None], method=method).validity.tolist() == [0, 0]


def test_pairs_of_markers_are_parted_better_than_with_the_defaults(monkeypatch):
    monkeypatch.syspath_prepend(STUDIES)
    study, rng = importlib.import_module("kiss_proposed"), np.random.default_rng(0)
    for diameter, apart in ((14.0, 1.0), (11.0, 1.0)):
        lone = study.drawn(study.places(rng, 10, diameter, 0.0), diameter)
        centres = study.places(rng, 100, diameter, apart)
        images, proposed = study.drawn(centres, diameter), propose(lone).scanning
        shares = [
            study.both_found(detect_frames(images, method=m), centres, diameter / 5) for m in (proposed, KissScanning())
        ]
        assert shares[0] >= 95 and shares[0] > shares[1] + 5
        assert (detect_frames(lone, method=proposed).counts == 1).all()


def test_the_levels_are_measured_and_the_threshold_lies_between_noise_and_markers():
    for noise, peak in ((1.0, 90.0), (4.0, 120.0)):
        gap = propose(grey(scene(4, noise=noise, peak=peak, ground=30.0))).gap
        assert gap.background == pytest.approx(30, abs=1) and gap.noise == pytest.approx(noise, rel=0.15)
        assert gap.peak == pytest.approx(30 + peak, abs=3 * noise)
        assert 30 + 3 * noise < gap.low < gap.threshold < gap.high < 30 + peak
        assert gap.threshold == pytest.approx(30 + 0.4 * (gap.peak - 30), abs=0.5) and gap.groups == 25


def marker_edges(image):
    """Where remains of 2 by 3 px touch nothing and are at most 3 px beside a marker."""
    bright = image > 20
    near, nearer = (ndimage.binary_dilation(bright, np.ones((n, n))) for n in (9, 7))
    inside = near & ~nearer
    inside[-2:], inside[:, -3:] = False, False
    return inside


def dim_ones(seed, *, frames=4):
    """A scene without noise of 25 markers, of which two are far dimmer."""
    rng, image = np.random.default_rng(seed), np.full(SIZE, 15.0)
    y, x = np.mgrid[: SIZE[0], : SIZE[1]]
    for k in range(25):
        u, v = 30 + 60 * (k % 5) + rng.uniform(-3, 3), 24 + 48 * (k // 5) + rng.uniform(-3, 3)
        image += (24.0 if k < 2 else 200.0) * np.clip(4.5 - np.hypot(x - u, y - v), 0, 1)
    return np.stack([image] * frames)


@pytest.mark.parametrize("seed", [5, 6])
def test_two_dim_markers_on_ground_without_noise_are_found(seed):
    images = grey(dim_ones(seed))
    assert detect_frames(images, method=propose(images).centroids).counts.tolist() == [25] * 4


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_what_compression_leaves_beside_moving_markers_is_no_marker(seed):
    images = scene(seed, noise=0.0, markers=25)
    rng = np.random.default_rng(seed)
    for image in images:  # two faint remains a frame beside markers, on ground from which the noise was taken
        for v, u in rng.permutation(np.argwhere(marker_edges(image)))[:2]:
            image[v : v + 2, u : u + 3] += 6.0
    proposed = propose(grey(images)).centroids
    assert proposed.threshold > 15 + 20, "above the remains by far"
    found = detect_frames(grey(images), method=proposed)
    assert found.counts.tolist() == [25] * 4 and not found.validity.any()


def test_sixteen_bits_are_the_same_images():
    images = grey(scene(5))
    plain, deep = propose(images), propose(images.astype(np.uint16) * 257)
    assert deep.white == 65535 and deep.findings == plain.findings == ()
    assert deep.centroids == replace(plain.centroids, threshold=deep.centroids.threshold)
    assert deep.centroids.threshold == pytest.approx(plain.centroids.threshold, abs=0.5)


def test_a_camera_of_twelve_bits_is_noticed_and_gets_a_threshold_in_its_own_range():
    images = grey(scene(6, peak=2500, ground=200, noise=30), np.uint16)
    proposal = propose(images)
    assert proposal.white == 4095 and proposal.findings[-1] == make_finding("few_bits_used", white=4095)
    assert 200 / 257 < proposal.centroids.threshold < 2700 / 257
    for method in methods(proposal):
        assert detect_frames(images, method=method).counts.tolist() == [25] * 4


def test_dark_markers_on_bright_ground_are_the_same_turned_over():
    images = grey(scene(7, ground=30.0))
    bright, dark = propose(images), propose(255 - images)
    assert dark.inverted and not bright.inverted and make_finding("markers_dark") in dark.findings
    assert dark.sizes == bright.sizes and dark.gap.threshold == pytest.approx(bright.gap.threshold)
    assert dark.centroids.threshold == pytest.approx(255 - bright.centroids.threshold, abs=0.1)
    for method in (*methods(dark), dark.nearest):
        assert method.inverted
    for method in methods(dark):
        assert detect_frames(255 - images, method=method).counts.tolist() == [25] * 4


def test_fields_of_interlaced_video_keep_their_flat_markers_whole():
    images = grey(scene(8, diameters=(9, 13)))[:, ::2]
    proposal = propose(images)
    assert proposal.scanning.min_ratio < 0.4 < 0.6 < proposal.scanning.max_ratio and proposal.centroids.max_aspect >= 3
    assert detect_frames(images, method=proposal.scanning).counts.tolist() == [25] * 4
    assert not detect_frames(images, method=proposal.scanning).merged.any()


def test_images_that_look_wrong_are_said_to():
    noise = np.random.default_rng(0).normal(0, 4, (3, *SIZE))
    y = np.arange(SIZE[0])[:, None]
    floor = scene(9) + 120.0 * (y > 170)
    cases = {
        "nothing_stands_out": 20 + noise,
        "images_white": np.full((2, *SIZE), 255.0),
        "light_clipped": scene(9, peak=600),
        "bright_without_markers": floor,
    }
    for kind, images in cases.items():
        proposal = propose(grey(images))
        (found,) = (one for one in proposal.findings if one.kind == kind)
        assert text_of(found) in proposal_text(proposal, "left")
    texture = 40 * ndimage.gaussian_filter(noise, (0, 2, 2)) + 60 + noise / 4
    proposal = propose(grey(texture))
    kinds = {one.kind for one in proposal.findings}
    assert not proposal.reasons or kinds & {"no_clear_gap", "bright_without_markers"}
    assert propose(grey(scene(9))).findings == ()


def test_without_markers_nothing_is_proposed_and_the_methods_are_the_defaults():
    proposal = propose(np.full((1, 40, 50), 7, np.uint8))
    assert proposal.reasons == () and proposal.sizes is None
    assert (proposal.centroids, proposal.scanning) == (type(proposal.centroids)(), type(proposal.scanning)())
    assert "No parameters can be proposed" in proposal_text(proposal, "left")


def test_the_text_is_a_table_of_a_session_file():
    """Also what is commented out, once the paper's method is asked for; each value has its reason beside it."""
    for images in (grey(scene(10)), 255 - grey(scene(10, ground=40.0))):
        proposal = propose(images)
        text = proposal_text(proposal, "left")
        assert method_of("detect", tomllib.loads(text)["detect"]) == proposal.centroids
        lines = [line.removeprefix("# ") for line in text.splitlines() if " = " in line and " method " not in line]
        lines = [line for line in lines if "`" not in line and not line.startswith(("min_width", "max_aspect"))]
        table = {"method": "kiss_scanning"} | tomllib.loads("\n".join(lines))
        assert method_of("detect", table) == proposal.scanning
        assert all(line.count("  # ") == 1 for line in lines if not line.startswith("inverted"))


class Recorded:
    """Frames as a camera gives them, counting the batches that were asked for."""

    def __init__(self, images):
        self.images, self.read = images, 0

    @property
    def n_frames(self):
        return len(self.images)

    def batches(self, n):
        for k in range(0, len(self.images), n):
            self.read += len(self.images[k : k + n])
            yield self.images[k : k + n]

    def v_offset(self, f):
        return 0.0


def test_a_recording_is_looked_at_all_over():
    images = np.repeat(grey(scene(11, frames=3)), 20, 0)
    images[:20] = 15
    source = Recorded(images)
    assert propose(source) == propose(images)
    assert propose(source).frames == 12 and source.read == 2 * len(images)
    assert propose(source, frames=1).reasons == ()  # the first frame is empty
    with pytest.raises(ValueError, match="wanted at least one"):
        propose(images[:0])
    with pytest.raises(ValueError, match="wanted"):
        propose(images.astype(float))


def test_a_sessions_cameras_are_asked_one_by_one_and_together(tmp_path):
    for name, peak in (("a", 200), ("b", 100)):
        for k, image in enumerate(grey(scene(12, peak=peak, frames=2))):
            write_png(tmp_path / f"{name}_{k:03}.png", image)
    settings = 'name = "s"\nrate_hz = 100\n[cameras]\nnames = ["a", "b"]\n[calibration]\nfile = "rig.toml"\n'
    (tmp_path / "session.toml").write_text(settings + '[[trials]]\nname = "t"\nimages = "{camera}_*.png"\n')
    found = propose_detection(tmp_path)
    assert list(found) == ["all", "a", "b"] and found["all"].frames == 4
    assert found["b"].centroids.threshold < found["all"].centroids.threshold < found["a"].centroids.threshold
    assert not found["a"].inverted
    (tmp_path / "dark").mkdir()
    (tmp_path / "dark" / "session.toml").write_text(
        settings + '[detect]\ninverted = true\n[[trials]]\nname = "t"\nimages = "../{camera}_*.png"\n'
    )
    assert all(proposal.inverted for proposal in propose_detection(tmp_path / "dark").values())
    alone = propose_detection(tmp_path / "a_*.png")
    assert [asdict(p.centroids) for p in alone.values()] == [asdict(found["a"].centroids)]
    unnamed = settings.replace('["a", "b"]', "[]") + '[[trials]]\nname = "t"\nimages = "{camera}_*.png"\n'
    (tmp_path / "session.toml").write_text(unnamed)
    write_rig_toml(tmp_path / "rig.toml", Rig(tuple(camera(name, (4000.0, k, 900.0)) for k, name in enumerate("ab"))))
    assert list(propose_detection(tmp_path)) == ["all", "a", "b"]  # as the calibration names them
    wand = unnamed.replace('file = "rig.toml"', 'wand = { lengths_mm = [500.0], images = "{camera}_*.png" }')
    (tmp_path / "session.toml").write_text(wand)
    with pytest.raises(KinemarkError, match="Name the cameras"):
        propose_detection(tmp_path)


@pytest.mark.parametrize("camera", [1, 2, 3, 4])
def test_the_dots_of_a_real_body_are_found(camera):
    """105 dots, two of which touch in some views; published by OpenPTV."""
    source = open_images(shared_data(f"cameras/dot_body_splitter/cal/cam{camera}.png"))
    proposal = propose(source)
    for method in methods(proposal):
        found = detect_frames(next(source.batches(1)), method=method)
        assert 103 <= (found.validity == 0).sum() <= 106
    assert "light_clipped" in {one.kind for one in proposal.findings}


@pytest.mark.parametrize("camera", [0, 1, 2, 3])
def test_real_leds_are_found_in_infrared_videos(camera):
    """Of the first 64 frames as many have all 15 LEDs and nothing else as with the defaults, save for one or two."""
    images = next(open_images(shared_data(f"cameras/ir_4cam_footage/calibration1_{camera}.mp4")).batches(64))
    proposal = propose(images)

    def complete(method):
        found = detect_frames(images, method=method)
        valid = np.bincount(np.repeat(np.arange(64), found.counts)[found.validity == 0], minlength=64)
        return int((valid == 15).sum())

    for method in methods(proposal):
        assert complete(method) >= max(complete(type(method)()) - 2, 20)
