"""Thresholds: dark markers, levels relative to each camera, saturated pixels; and what bad images get."""

from threading import Event

import av
import numpy as np
import pytest
from scipy import ndimage
from threadpoolctl import threadpool_info, threadpool_limits

from kinemark.data import KinemarkError, Validity, same
from kinemark.detect import Centroids, detect, detect_frames
from kinemark.detect.levels import levelled
from kinemark.io.images import open_images
from kinemark.io.video import write_video
from support.films import Film

H, W = 60, 90
AT = (np.arange(24 * 6) + 0.5) / 6 - 0.5 - 11.5


def disc(u, v, d, blur=0.5):
    """(24, 24) light of a disc about (u, v) from the middle."""
    sharp = np.clip((d / 2 - np.hypot(AT - u, AT[:, None] - v)) * 6 + 0.5, 0, 1)
    return ndimage.gaussian_filter(sharp, blur * 6).reshape(24, 6, 24, 6).mean((1, 3))


def shares(rng, n=4):
    """(n, H, W) light of four discs a frame, and their places (n, 4, 2) px."""
    light, places = np.zeros((n, H, W)), np.zeros((n, 4, 2))
    for f in range(n):
        for k, (x, y) in enumerate(((4, 4), (60, 3), (10, 34), (58, 33))):
            u, v = rng.uniform(-0.5, 0.5, 2)
            light[f, y : y + 24, x : x + 24] += disc(u, v, 8)
            places[f, k] = x + 11.5 + u, y + 11.5 + v
    return light, places


def photo(light, rng, *, ground=20.0, peak=150.0, noise=2.0):
    return np.clip(np.rint(ground + peak * light + noise * rng.normal(size=light.shape)), 0, 255).astype(np.uint8)


def matched(blobs, places):
    """Detections (n, 4, 2) and their covariances in the order of the places."""
    assert (blobs.counts == 4).all()
    uv, cov = blobs.uv.reshape(-1, 4, 2), blobs.cov.reshape(-1, 4, 2, 2)
    nearest = np.linalg.norm(uv[:, None] - places[:, :, None], axis=-1).argmin(2)
    return (np.take_along_axis(a, nearest.reshape(*nearest.shape, *[1] * (a.ndim - 2)), 1) for a in (uv, cov))


# ---- Dark markers ----


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
def test_dark_markers_are_bright_ones_of_the_negative(dtype):
    light, places = shares(np.random.default_rng(0))
    images = photo(light, np.random.default_rng(1)).astype(dtype) * (257 if dtype == np.uint16 else 1)
    bright = detect_frames(images, method=Centroids(threshold=80))
    dark = detect_frames(np.invert(images), method=Centroids(threshold=255 - 80, inverted=True))
    np.testing.assert_allclose(dark.uv, bright.uv, atol=1e-9)
    np.testing.assert_allclose(dark.cov, bright.cov, rtol=1e-9)
    np.testing.assert_array_equal(dark.peak, np.iinfo(dtype).max - bright.peak)
    assert np.abs(next(iter(matched(dark, places))) - places).max() < 0.05


def test_a_grey_level_at_the_threshold_is_on_no_side_of_it():
    image = np.full((1, 20, 20), 100, np.uint8)
    image[0, 5:9, 5:9] = 60
    for method in (Centroids(threshold=100), Centroids(threshold=60, inverted=True)):
        assert detect_frames(image, method=method).counts.sum() == 0
    assert detect_frames(image, method=Centroids(threshold=61, inverted=True)).counts.sum() == 1


# ---- Relative thresholds ----


@pytest.mark.parametrize("inverted", [False, True])
@pytest.mark.parametrize(("ground", "peak"), [(8.0, 40.0), (20.0, 150.0), (90.0, 120.0)])
def test_a_relative_threshold_follows_the_camera(ground, peak, inverted):
    """The same share of the way for dim and for bright cameras, so the same pixels are white."""
    light, places = shares(np.random.default_rng(2))
    images = photo(light, np.random.default_rng(3), ground=ground, peak=peak, noise=0.01 * peak)
    images = np.invert(images) if inverted else images
    method = Centroids(relative_threshold=0.4, inverted=inverted)
    found = levelled(method, images)
    level = 255 - found.threshold if inverted else found.threshold
    assert abs(level - (ground + 0.4 * peak)) < 0.04 * peak
    assert found.relative_threshold is None
    uv, _ = matched(detect_frames(images, method=method), places)
    assert np.sqrt(np.mean((uv - places) ** 2)) < 0.02


def test_a_strobe_and_a_lamp_do_not_move_the_level():
    light, _ = shares(np.random.default_rng(4))
    images = photo(light, np.random.default_rng(5), peak=100.0)
    level = levelled(Centroids(relative_threshold=0.5), images).threshold
    images[:, 26:34, 40:50] = 255
    assert abs(levelled(Centroids(relative_threshold=0.5), images).threshold - level) < 6


def test_the_level_is_measured_once_where_something_is_seen():
    """Empty frames before the first marker leave it open; later frames that are brighter do not move it."""
    light, _ = shares(np.random.default_rng(6), 60)
    light[:20] = 0
    images = photo(light, np.random.default_rng(7), peak=100.0)
    images[40:] = np.minimum(images[40:].astype(int) * 2, 255)
    found = detect([Film(images)], cameras=["a"], rate=50.0, method=Centroids(relative_threshold=0.5))
    first = levelled(Centroids(relative_threshold=0.5), images[16:32])
    assert same(found.uv, detect_frames(images, method=first).uv)
    assert found.counts[0, :20].sum() == 0 and (found.counts[0, 20:] == 4).all()
    assert levelled(Centroids(relative_threshold=0.5), images[:16]) is None


class Large(Film):
    """A recording whose images are so large that few come at a time."""

    def batches(self, n):
        return super().batches(min(n, 3))


def test_the_level_is_the_same_however_many_images_come_at_a_time():
    """A dim reflection that is alone in the first frames is no level of markers that come in the ninth."""
    light, _ = shares(np.random.default_rng(6), 20)
    images = photo(light, np.random.default_rng(7), peak=200.0)
    images[:8] = photo(light[:8], np.random.default_rng(8), peak=60.0)
    method = Centroids(relative_threshold=0.5)
    few, many = (detect([kind(images)], cameras=["a"], rate=50.0, method=method) for kind in (Large, Film))
    assert same(few.uv, many.uv)
    assert few.counts.tolist() == many.counts.tolist()


def test_without_it_the_method_stays_as_it_is():
    method = Centroids(threshold=70)
    assert levelled(method, np.zeros((2, 4, 4), np.uint8)) is method


# ---- Saturation ----


@pytest.mark.parametrize("white", [255, 235])
def test_covariances_of_saturated_markers_are_true(white):
    """White of the sensor, or of video whose white is lower: its pixels have no noise, and the covariance knows."""
    rng, squared, usual = np.random.default_rng(8), [], []
    for _ in range(3):
        light, places = shares(rng, 40)
        images = np.minimum(photo(light, rng, peak=600.0, noise=6.0), white).astype(np.uint8)
        uv, cov = matched(
            detect_frames(images, method=Centroids(noise_sd=6.0, correct_occlusion=False, max_discs=1)), places
        )
        off = uv - places
        squared.append(np.einsum("fki,fkij,fkj->fk", off, np.linalg.inv(cov), off) / 2)
        usual.append(cov[..., 0, 0].mean())
    assert 0.5 < np.mean(squared) < 1.3
    assert (images == white).sum() > 100


def test_a_plateau_with_noise_is_not_taken_for_white():
    """Peaks of several markers are equal by chance, the more so the less noise there is."""
    light, places = shares(np.random.default_rng(9), 150)
    images = photo(light, np.random.default_rng(10), peak=180.0, noise=1.0)
    blobs = detect_frames(images, method=Centroids(noise_sd=1.0))
    peaks = np.sort(blobs.peak.reshape(-1, 4), axis=1)
    assert (peaks[:, 1] == peaks[:, 3]).mean() > 0.3
    uv, cov = matched(blobs, places)
    off = uv - places
    assert 0.6 < (np.einsum("fki,fkij,fkj->fk", off, np.linalg.inv(cov), off) / 2).mean() < 1.2


# ---- Bad images ----

METHODS = [
    Centroids(),
    Centroids(threshold=200, inverted=True),
    Centroids(relative_threshold=0.5),
    Centroids(max_edge_sd=1.0),
]


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
@pytest.mark.parametrize("white", [False, True])
def test_dark_and_white_images_have_no_markers(method, dtype, white):
    images = np.full((3, H, W), np.iinfo(dtype).max if white else 0, dtype)
    found = detect_frames(images, method=method)
    assert len(found.counts) == 3 and not (found.validity == Validity.VALID).any()


def test_colour_images_are_read_as_grey(tmp_path):
    """A grey scene stored in colour gives the same markers; three channels in memory are refused."""
    light, _ = shares(np.random.default_rng(11), 1)
    grey = photo(light, np.random.default_rng(12))[0]
    frame = av.VideoFrame.from_ndarray(np.stack([grey] * 3, -1), format="rgb24")
    with av.open(str(tmp_path / "000.png"), "w", format="image2") as container:
        stream = container.add_stream("png", 1)
        stream.width, stream.height, stream.pix_fmt = W, H, "rgb24"
        container.mux(stream.encode(frame))
        container.mux(stream.encode(None))
    source = open_images(str(tmp_path / "*.png"))
    found = detect([source], cameras=["a"], rate=50.0)
    np.testing.assert_allclose(found.uv, detect_frames(grey[None]).uv, atol=0.02)
    with pytest.raises(ValueError, match="images have shape"):
        detect_frames(np.stack([grey] * 3, -1)[None])


def test_a_corrupt_recording_is_named(tmp_path):
    light, _ = shares(np.random.default_rng(13), 20)
    path = tmp_path / "a.mkv"
    write_video(path, photo(light, np.random.default_rng(14)), rate=50.0)
    source = open_images(str(path))
    whole = detect([source], cameras=["a"], rate=50.0)
    assert (whole.counts == 4).all()
    data = bytearray(path.read_bytes())
    data[len(data) // 2 : len(data) // 2 + 4000] = bytes(4000)
    path.write_bytes(data)
    with pytest.raises(KinemarkError, match=r"a\.mkv"):
        detect([open_images(str(path))], cameras=["a"], rate=50.0)


def test_frames_of_another_size_are_refused(tmp_path):
    """Within one recording; cameras may differ from each other."""
    light, _ = shares(np.random.default_rng(15), 2)
    film = photo(light, np.random.default_rng(16))
    found = detect([Film(film), Film(film[:, :, :45])], cameras=["a", "b"], rate=50.0)
    assert found.counts.tolist() == [[4, 4], [2, 2]]

    class Torn(Film):
        def batches(self, n):
            return iter([self.images[:1], self.images[1:, :, :45]])

    with pytest.raises(KinemarkError, match=r"Camera a: frame 2 of 2 .* 45 × 60 .* 90 × 60"):
        detect([Torn(film)], cameras=["a"], rate=50.0)


# ---- Threads ----


@pytest.mark.parametrize("cores", [1, 2, 5])
def test_any_number_of_processors_gives_the_same(monkeypatch, cores):
    films = [photo(shares(np.random.default_rng(k), 40)[0], np.random.default_rng(k)) for k in range(3)]
    usual = detect([Film(film) for film in films], cameras=["a", "b", "c"], rate=50.0)
    monkeypatch.setattr("os.cpu_count", lambda: cores)
    again = detect([Film(film) for film in films], cameras=["a", "b", "c"], rate=50.0)
    assert same(again, usual)


def test_the_next_images_are_decoded_while_markers_are_looked_for():
    """When a batch is done with, the next one has been asked for, and need not wait for that."""
    asked = {k: Event() for k in range(0, 64, 16)}
    ready = []

    class Noted(Film):
        def batches(self, n):
            for k in range(0, self.n_frames, n):
                asked[k].set()
                yield self.images[k : k + n]

    def progress(done):
        ready.append(done == 64 or asked[done].wait(1.0))

    detect([Noted(np.zeros((64, 8, 8), np.uint8))], cameras=["a"], rate=50.0, progress=progress)
    assert ready == [True] * 4


def test_matrix_products_take_one_thread():
    """Threads of BLAS that wait for work cost more than they bring, and cameras have threads of their own."""
    used = []

    def progress(done):
        used.extend(pool["num_threads"] for pool in threadpool_info() if pool["user_api"] == "blas")

    with threadpool_limits(2, user_api="blas"):
        detect([Film(np.zeros((3, 8, 8), np.uint8))], cameras=["a"], rate=50.0, progress=progress)
    assert used and set(used) == {1}
