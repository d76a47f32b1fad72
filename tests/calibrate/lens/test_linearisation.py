"""The lens of a camera from plane grids: exactness, error bars, choice of terms, refusals, OpenCV, real pictures."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from kinemark.calibrate import GridView, Linearisation, find_corners, linearise, straightness
from kinemark.calibrate.lens.lens_choice import LensScore, simplest
from kinemark.calibrate.lens.plane_views import PlanePoints, Planes, moved, plane_jacobian, seen_at, zoomed
from kinemark.data import Camera, KinemarkError
from kinemark.geometry import parameter_jacobian, project, undistort
from kinemark.geometry.sphere_offset import sphere_offset
from kinemark.io.images import read_image
from support.shared import shared_data
from support.studies import figures, printed

SIZE = np.array([1280, 1024])
XY = 50.0 * np.stack(np.meshgrid(np.arange(12) - 5.5, np.arange(9) - 4.0), -1).reshape(-1, 2)
PLANE = np.column_stack([XY, np.zeros(len(XY))])
LENS = (-0.22, 0.08, 6e-4, -4e-4, 0.0)
FACING = [((0, 0, 0), (0, 0, 650))]
TILTED = [
    ((28, 5, 4), (0, 0, 800)),
    ((-25, 20, 90), (20, 0, 760)),
    ((5, -32, 0), (-10, 10, 780)),
    ((3, 2, 1), (0, 0, 640)),
]


def views(poses, *, lens=LENS, focal=1250.0, ratio=1.002, noise=0.0, seed=0, xy=XY):
    """The camera, and what it sees of the grid in these poses (angles deg, place mm)."""
    K = np.array([[focal, 0, 647.0], [0, focal * ratio, 505.0], [0, 0, 1]])
    camera = Camera("c", SIZE, K, np.eye(3), np.zeros(3), np.array(lens))
    rng, seen = np.random.default_rng(seed), []
    for angles, t in poses:
        R = Rotation.from_euler("xyz", angles, degrees=True).as_matrix()
        uv = project(camera, np.column_stack([xy, np.zeros(len(xy))]) @ R.T + t)
        seen.append(GridView(uv + noise * rng.normal(size=uv.shape), xy))
    return camera, seen


def values(camera):
    return np.concatenate([np.diag(camera.K)[:2], camera.K[:2, 2], camera.distortion])


def test_without_noise_the_camera_comes_back():
    true, seen = views(TILTED)
    fit = linearise("c", SIZE, seen, method=Linearisation(3, True))
    assert fit.focal_known
    assert values(fit.camera) == pytest.approx(values(true), abs=1e-3)
    assert fit.camera.residual < 1e-5
    assert fit.straightness[0] > 1 > 1e-5 > fit.straightness[1]


def test_the_derivative_is_that_of_differences():
    true, _ = views(TILTED)
    rng = np.random.default_rng(0)
    R = Rotation.from_euler("xyz", [angles for angles, _ in TILTED], degrees=True).as_matrix()
    planes = Planes(true, R, np.array([t for _, t in TILTED], float))
    view = np.sort(rng.integers(0, 4, 20))
    points = PlanePoints(
        view, PLANE[rng.integers(0, len(PLANE), 20)], np.zeros((20, 2)), np.tile(np.eye(2), (20, 1, 1))
    )
    J = plane_jacobian(planes, points)
    for k in range(15):
        for v in range(4) if k >= 9 else [None]:
            step = np.zeros(9 + 6 * 4)
            step[k if v is None else k + 6 * v] = 1e-6
            numeric = (seen_at(moved(planes, step), points) - seen_at(moved(planes, -step), points)) / 2e-6
            wanted = J[..., k] if v is None else np.where((view == v)[:, None], J[..., k], 0.0)
            assert numeric == pytest.approx(wanted, rel=1e-5, abs=1e-4)


def test_a_zoom_leaves_the_picture_of_a_plane_that_faces_the_camera():
    true, _ = views(FACING)
    planes = Planes(true, np.eye(3)[None], np.array([[10.0, 5.0, 650.0]]))
    n = len(PLANE)
    points = PlanePoints(np.zeros(n, int), PLANE, np.zeros((n, 2)), np.tile(np.eye(2), (n, 1, 1)))
    assert seen_at(zoomed(planes, 0.3), points) == pytest.approx(seen_at(planes, points), abs=1e-9)


def test_the_error_bars_are_true():
    """χ² of the eight camera parameters over their covariance, 16 simulations: mean 8, and 95 % below 15.5."""
    chi2 = []
    for seed in range(16):
        true, seen = views(TILTED[:3], lens=(-0.2, 0.05, 5e-4, -3e-4, 0), noise=0.1, seed=seed, xy=XY[::2])
        fit = linearise("c", SIZE, seen, method=Linearisation(2, True, reject=np.inf))
        free = np.arange(8)
        off = (values(fit.camera) - values(true))[free]
        chi2.append(off @ np.linalg.solve(fit.camera.cov[np.ix_(free, free)], off))
    assert 8 * 0.7 < np.mean(chi2) < 8 * 1.35
    assert np.mean(np.array(chi2) < 15.5) >= 0.85


def test_the_covariance_is_that_of_plain_least_squares():
    """In fx, fy, cx, cy, the lens terms and the poses themselves, without the zoom the fit moves along."""
    _, seen = views(TILTED, noise=0.1)
    fit = linearise("c", SIZE, seen, method=Linearisation(3, True, reject=np.inf))
    n, V = len(XY), len(seen)
    J = np.zeros((V, 2 * n, 9 + 6 * V))
    for v, camera in enumerate(fit.views):
        part = parameter_jacobian(camera, PLANE).reshape(2 * n, 15)
        J[v, :, :9], J[v, :, 9 + 6 * v : 15 + 6 * v] = part[:, :9], part[:, 9:]
    J = J.reshape(-1, 9 + 6 * V)
    scale = 1 / np.linalg.norm(J, axis=0)
    nu = len(J) - J.shape[1]
    chi2 = sum((r**2).sum() for r in fit.residual)
    cov = scale[:, None] * np.linalg.inv((J * scale).T @ (J * scale)) * scale * chi2 / (nu - 2)
    sd = np.sqrt(np.diag(cov)[:9])
    assert fit.camera.cov[:9, :9] / sd / sd[:, None] == pytest.approx(cov[:9, :9] / sd / sd[:, None], abs=1e-2)


def test_covariances_of_points_need_only_be_right_in_proportion():
    _, seen = views(TILTED, noise=0.1)
    cov = np.tile(np.eye(2), (len(XY), 1, 1))
    fits = [
        linearise("c", SIZE, [v._replace(cov=scale * cov) for v in seen], method=Linearisation(2, True))
        for scale in (0.01, 4.0)
    ]
    assert values(fits[0].camera) == pytest.approx(values(fits[1].camera), rel=1e-4)
    assert fits[0].camera.cov == pytest.approx(fits[1].camera.cov, rel=1e-3)


def test_a_view_that_states_no_covariance_counts_like_the_others():
    _, seen = views(TILTED, noise=0.1)
    cov = np.tile(1e-4 * np.eye(2), (len(XY), 1, 1))
    mixed = [seen[0], *(v._replace(cov=cov) for v in seen[1:])]
    fits = [linearise("c", SIZE, given, method=Linearisation(2, True)) for given in (seen, mixed)]
    assert values(fits[0].camera) == pytest.approx(values(fits[1].camera), rel=1e-6)


def test_points_that_are_known_better_count_more():
    """Half of the points have ten times the noise: told so, the focal length is known better than if not."""
    loud = np.arange(len(XY)) % 2 == 0
    cov = np.where(loud[:, None, None], 100.0, 1.0) * np.eye(2)
    off = {True: [], False: []}
    for seed in range(4):
        true, seen = views(TILTED[:3])
        rng = np.random.default_rng(seed)
        told = [
            GridView(v.uv + 0.05 * np.where(loud, 10, 1)[:, None] * rng.normal(size=v.uv.shape), XY, cov) for v in seen
        ]
        for weighted in off:
            given = told if weighted else [v._replace(cov=None) for v in told]
            fit = linearise("c", SIZE, given, method=Linearisation(2, True, reject=np.inf))
            off[weighted].append(fit.camera.K[0, 0] - true.K[0, 0])
    assert np.std(off[True]) < 0.5 * np.std(off[False])


@pytest.mark.parametrize(
    ("lens", "terms"),
    [((0,) * 5, (0, False)), ((-0.15, 0, 0, 0, 0), (1, False)), ((-0.3, 0.15, 0, 0, 0), (2, False)), (LENS, (2, True))],
)
def test_the_terms_the_lens_has_are_chosen(lens, terms):
    _, seen = views(TILTED, lens=lens, noise=0.05)
    fit = linearise("c", SIZE, seen)
    assert (fit.radial, fit.tangential) == terms
    assert len(fit.scores) == 8
    assert {s.radial for s in linearise("c", SIZE, seen, method=Linearisation(tangential=False)).scores} == {0, 1, 2, 3}


def test_a_gain_that_is_nothing_beside_the_noise_buys_no_terms():
    small = LensScore(1, False, 1.004, 0.008, 0.001)
    assert simplest([small, LensScore(1, True, 1.0, 0.0, 0.0)]) == small
    large = LensScore(1, False, 1.01, 0.0201, 0.001)
    assert simplest([large, LensScore(1, True, 1.0, 0.0, 0.0)]).tangential


def test_one_view_that_faces_the_camera_tells_the_lens_and_says_that_the_focal_length_is_unknown():
    true, seen = views(FACING, lens=(-0.2, 0, 0, 0, 0), ratio=1.0, noise=0.02)
    fit = linearise("c", SIZE, seen)
    assert not fit.focal_known
    assert fit.camera.K[0, 0] == pytest.approx(1280)
    assert fit.camera.cov[0, 0] == 0
    grid = np.stack(np.meshgrid(np.linspace(40, 1240, 9), np.linspace(40, 980, 7)), -1).reshape(-1, 2)
    a, b = undistort(fit.camera, grid), undistort(true, grid)
    plane = np.column_stack([a, np.ones(len(a))])
    rows = [np.hstack([plane, 0 * plane, -b[:, :1] * plane]), np.hstack([0 * plane, plane, -b[:, 1:] * plane])]
    h = plane @ np.linalg.svd(np.concatenate(rows) / 1e3, full_matrices=False)[2][-1].reshape(3, 3).T
    assert np.sqrt(((h[:, :2] / h[:, 2:] - b) ** 2).sum(1).mean()) < 0.05
    assert fit.straightness[0] > 1
    assert fit.straightness[1] < 0.02


def test_grids_of_different_sizes_and_an_unknown_image_size():
    true, seen = views(TILTED, noise=0.02)
    _, other = views(TILTED[1:2], noise=0.02, xy=1.3 * XY[XY[:, 0] > -200], seed=3)
    fit = linearise("c", (0, 0), [*seen, *other])
    assert fit.camera.K[0, 0] == pytest.approx(true.K[0, 0], abs=5 * np.sqrt(fit.camera.cov[0, 0]))
    assert np.isnan(fit.coverage)
    assert [len(k) for k in fit.kept] == [len(XY)] * 4 + [len(other[0].uv)]


def test_wrong_points_are_left_out_and_missing_ones_stay_missing():
    true, seen = views(TILTED, noise=0.05)
    spoiled = seen[0].uv.copy()
    spoiled[[3, 40, 77]] += [[4.0, 0], [0, -3.0], [2.0, 2.0]]
    spoiled[10] = np.nan
    fit = linearise("c", SIZE, [seen[0]._replace(uv=spoiled), *seen[1:]])
    assert set(np.flatnonzero(~fit.kept[0])) == {3, 10, 40, 77}
    assert all(kept.all() for kept in fit.kept[1:])
    assert np.isnan(fit.residual[0][10]).all()
    assert np.linalg.norm(fit.residual[0][[3, 40, 77]], axis=1) == pytest.approx([4, 3, 2.83], abs=0.3)
    sd = np.sqrt(np.diag(fit.camera.cov)[:4])
    assert (np.abs(values(fit.camera) - values(true))[:4] < 4 * sd).all()


def test_spheres_are_taken_for_what_they_are():
    """Centroids of 25 mm spheres near by lie up to a tenth of a pixel beside their centres."""
    true, seen = views(TILTED)
    bulged = []
    for view, (angles, t) in zip(seen, TILTED, strict=True):
        R = Rotation.from_euler("xyz", angles, degrees=True).as_matrix()
        here = Camera("c", SIZE, true.K, R, np.array(t, float), true.distortion)
        bulged.append(view._replace(uv=view.uv + sphere_offset(here, PLANE, diameter=25.0)))
    off = [
        np.abs(linearise("c", SIZE, bulged, method=Linearisation(2, True), diameter=d).camera.K[0, 0] - true.K[0, 0])
        for d in (None, 25.0)
    ]
    assert off[1] < 0.1 * off[0]


def test_straightness_is_zero_for_any_ideal_picture_and_the_noise_for_a_noisy_one():
    _, seen = views(TILTED[:1], lens=(0,) * 5)
    assert straightness(seen[0].uv, XY) < 1e-9
    noisy = seen[0].uv + np.random.default_rng(0).normal(0, 0.5, XY.shape)
    n = np.array([12] * 9 + [9] * 12)
    assert straightness(noisy, XY) == pytest.approx(0.5 * np.sqrt(((n - 2).sum()) / n.sum()), rel=0.1)
    assert np.isnan(straightness(noisy[[0, 14]], XY[[0, 14]]))


def replaced(fault):
    _, (seen, *_) = views(TILTED)
    return fault(seen)


REFUSED = {
    "few points": (lambda v: GridView(v.uv[:10], v.xy[:10]), "view 1: 10 points are seen, and a lens needs 15"),
    "nothing seen": (lambda v: GridView(np.full_like(v.uv, np.nan), v.xy), "0 points are seen"),
    "one row": (lambda v: GridView(np.tile(v.uv[:12], (2, 1)), np.tile(v.xy[:12], (2, 1))), "lie on one line on the"),
    "a picture edge on": (lambda v: GridView(v.uv * [1, 0], v.xy), "lie on one line in the picture"),
    "points exchanged": (
        lambda v: GridView(v.uv, v.xy[np.random.default_rng(0).permutation(len(v.xy))]),
        "Check which point",
    ),
    "columns miscounted": (lambda v: GridView(v.uv, np.roll(v.xy, 5, axis=0)), "Check which point"),
    "a corner only": (lambda v: GridView(v.uv * 0.3, v.xy), "leave out the middle of the image at"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_tells_no_lens_is_refused_with_the_reason(case):
    fault, words = REFUSED[case]
    with pytest.raises(KinemarkError, match=words):
        linearise("c", SIZE, [replaced(fault)])


def test_wrong_calls_are_refused():
    with pytest.raises(ValueError, match="there is no view"):
        linearise("c", SIZE, [])
    with pytest.raises(ValueError, match=r"xy of view 1 has shape \(108, 3\), wanted \(108, 2\)"):
        linearise("c", SIZE, [GridView(np.zeros((108, 2)), PLANE)])
    with pytest.raises(ValueError, match="cov of view 1"):
        linearise("c", SIZE, [GridView(np.zeros((108, 2)), XY, np.eye(2))])
    with pytest.raises(ValueError, match="radial is 4"):
        Linearisation(radial=4)
    with pytest.raises(ValueError, match="reject is 1"):
        Linearisation(reject=1)


def opencv(seen, size, *, radial, tangential):
    """`calibrateCamera` with as many terms: RMS, and fx fy cx cy k1 k2 p1 p2 k3."""
    cv2 = pytest.importorskip("cv2")
    off = [cv2.CALIB_FIX_K1, cv2.CALIB_FIX_K2, cv2.CALIB_FIX_K3][radial:]
    flags = sum(off) + (0 if tangential else cv2.CALIB_ZERO_TANGENT_DIST)
    plane = [np.column_stack([v.xy, np.zeros(len(v.xy))]).astype(np.float32) for v in seen]
    uv = [v.uv.astype(np.float32) for v in seen]
    rms, K, k, *_ = cv2.calibrateCamera(plane, uv, tuple(map(int, size)), np.eye(3), np.zeros(5), flags=flags)
    return rms, np.concatenate([[K[0, 0], K[1, 1], K[0, 2], K[1, 2]], np.ravel(k)[:5]])


@pytest.mark.parametrize(("radial", "tangential"), [(1, False), (2, True), (3, True)])
def test_the_camera_is_opencvs(radial, tangential):
    """The same least squares, so the same answer, whatever the terms."""
    _, seen = views(TILTED, noise=0.1)
    fit = linearise("c", SIZE, seen, method=Linearisation(radial, tangential, reject=np.inf))
    rms, theirs = opencv(seen, SIZE, radial=radial, tangential=tangential)
    sd = np.sqrt(np.diag(fit.camera.cov)[:9])
    assert fit.camera.residual <= rms * (1 + 1e-4)
    assert (np.abs(values(fit.camera) - theirs) <= 0.05 * sd + 1e-9).all()


def test_the_real_chessboards():
    """13 pictures with strong barrel distortion; published: RMS 0.409 px, f 536.1, k1 −0.265."""
    xy = 25.0 * np.array([(c, r) for r in range(6) for c in range(9)], float)
    paths = sorted(shared_data("cameras/chessboard_left").glob("*.jpg"))
    seen = [GridView(find_corners(read_image(path), columns=9, rows=6).reshape(-1, 2), xy) for path in paths[::3]]
    assert all(np.isfinite(v.uv).all() for v in seen)
    fit = linearise("left", (640, 480), seen, method=Linearisation(1, False, reject=np.inf))
    assert fit.camera.residual < 0.409
    assert fit.camera.K[0, 0] == pytest.approx(536.1, abs=6)
    assert fit.camera.distortion[0] == pytest.approx(-0.265, abs=0.01)
    assert fit.straightness[1] < 0.2 * fit.straightness[0]
    rms, theirs = opencv(seen, (640, 480), radial=1, tangential=False)
    assert fit.camera.residual <= rms * (1 + 1e-4)
    assert values(fit.camera)[:4] == pytest.approx(theirs[:4], abs=0.3)


@pytest.mark.nightly
def test_the_study_prints_the_figures_of_the_documentation():
    shared_data("cameras/chessboard_left")
    text = printed("linearisation")
    for row in ("weak barrel, one picture", "strong barrel, one picture"):
        inside, right, before, after = figures(text, row)[:4]
        assert inside == right == 300
        assert before > 1.5
        assert after < 0.01
        assert figures(text, row)[-1] < 0.02
    assert figures(text, "strong barrel, 5 pictures")[-1] < 0.02
    for lens in ("weak barrel  ", "strong barrel  "):
        plain, straightened, own, held = figures(text, lens)
        assert plain > 1.5
        assert max(straightened, held) < 0.06
        assert own < 0.2
    assert figures(text, "chessboard_left:")[:2] == [702, 702]
    for camera in range(1, 5):
        assert figures(text, f"dot_target_4cam {camera}")[:3] == pytest.approx([95, 95, 0.13], abs=0.03)
        assert figures(text, f"dot_body_splitter {camera}")[:3] == pytest.approx([105, 105, 0.77], abs=0.05)
