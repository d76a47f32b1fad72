"""Grids of dots and chessboards: which point of a picture is which, and where (KISS 3.2)."""

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter
from scipy.spatial.transform import Rotation

from kinemark.calibrate import assign_points, find_corners, order_grid, part_of_grid
from kinemark.data import Camera, KinemarkError
from kinemark.detect import Centroids, detect_frames
from kinemark.geometry import fit_dlt, from_dlt, project, undistort
from kinemark.io.images import read_image
from kinemark.synth import dot_grid, look_at, render
from support.shared import shared_data

COLUMNS, ROWS = 20, 15
SIZE = (1280, 1024)
XY = np.stack(np.meshgrid(np.arange(COLUMNS), np.arange(ROWS)), -1).reshape(-1, 2).astype(float)


def camera(*, roll=0.0, tilt=(0.0, 0.0), away=27.0, lens=(0.0,) * 5, f=1300.0):
    """A camera before the grid XY, its middle on the axis; roll and tilt in deg, away in pitches."""
    K = np.array([[f, 0, 639.5], [0, f, 511.5], [0, 0, 1]])
    R = Rotation.from_euler("zyx", [roll, *tilt], degrees=True).as_matrix()
    middle = np.append(XY.mean(0), 0.0)
    return Camera("c", np.array(SIZE), K, R, np.array([0, 0, away]) - R @ middle, np.array(lens))


def seen(cam, *, lost=(), strays=0, noise=0.0, rng=None):
    """Points (n, 2) px in random order, strays among them, and which of them each place of the grid is (N), or −1."""
    rng = rng or np.random.default_rng(0)
    uv = project(cam, np.column_stack([XY, np.zeros(len(XY))]))
    uv = uv + noise * rng.normal(size=uv.shape)
    there = np.setdiff1d(np.arange(len(uv)), lost)
    others = rng.uniform([0, 0], SIZE, (strays, 2))
    points = np.concatenate([uv[there], others])
    order = rng.permutation(len(points))
    where = np.full(len(uv), -1)
    where[there] = np.argsort(order)[: len(there)]
    return points[order], where.reshape(ROWS, COLUMNS)


@pytest.mark.parametrize("roll", [0, 20, -40, 89, 91, 140, 180, 270])
def test_the_grid_is_read_like_a_page_however_it_is_held(roll):
    """Rows run to the right as seen; held upside down, the other end is the first."""
    uv, where = seen(camera(roll=roll, lens=(-0.25, 0.05, 0, 0, 0)))
    index = order_grid(uv, columns=COLUMNS, rows=ROWS)
    assert (index == (where if np.cos(np.radians(roll)) > 0 else where[::-1, ::-1])).all()
    assert uv[index[:, -1], 0].mean() > uv[index[:, 0], 0].mean()


def test_no_dot_is_ever_mistaken():
    """Any tilt to 45°, any roll, barrel or cushion, noise, 5 % of the dots missing and 15 strays among them."""
    rng, placed, present = np.random.default_rng(5), 0, 0
    for _ in range(10):
        lens = (rng.uniform(-0.3, 0.1), 0, 0, 0, 0)
        cam = camera(roll=rng.uniform(-80, 80), tilt=rng.uniform(-45, 45, 2), away=rng.uniform(27, 40), lens=lens)
        lost = rng.choice(300, 15, replace=False)
        uv, where = seen(cam, lost=lost, strays=15, noise=0.3, rng=rng)
        index = order_grid(uv, columns=COLUMNS, rows=ROWS)
        true = np.linalg.norm(uv[index] - uv[where], axis=-1)[(index >= 0) & (where >= 0)]
        assert true.max() < 3  # a stray within 3 px may stand for its dot
        assert (index[where < 0] >= 0).mean() < 0.1
        placed, present = placed + len(true), present + (where >= 0).sum()
    assert placed > 0.995 * present


def test_a_mirrored_picture_is_a_grid_too():
    uv, where = seen(camera(tilt=(10, 5)))
    uv[:, 0] = SIZE[0] - 1 - uv[:, 0]
    assert (order_grid(uv, columns=COLUMNS, rows=ROWS) == where[:, ::-1]).all()


def test_missing_dots_stay_empty_and_points_that_are_nan_are_passed_over():
    lost = [0, 19, 47, 48, 150, 299]
    uv, where = seen(camera(tilt=(15, -10)), lost=lost)
    uv = np.insert(uv, 3, np.nan, axis=0)
    index = order_grid(uv, columns=COLUMNS, rows=ROWS)
    assert set(np.flatnonzero(index.ravel() < 0)) == set(lost)
    assert (index[where >= 0] == where[where >= 0] + (where[where >= 0] >= 3)).all()


def test_a_reflection_does_not_take_the_place_of_a_missing_dot():
    """A fifth of a cell off the dot's place, where the dots around it leave a hundredth in doubt."""
    lost = [105, 210]
    uv, _ = seen(camera(tilt=(15, -10), lens=(-0.2, 0, 0, 0, 0)), lost=lost)
    whole, where = seen(camera(tilt=(15, -10), lens=(-0.2, 0, 0, 0, 0)))
    place = whole[where.ravel()]
    strays = [place[k] + 0.2 * (place[k + 1] - place[k]) for k in lost]
    index = order_grid(np.concatenate([uv, strays]), columns=COLUMNS, rows=ROWS)
    assert set(np.flatnonzero(index.ravel() < 0)) == set(lost)


def test_rows_and_columns_exchanged_read_the_grid_sideways():
    uv, where = seen(camera())
    index = order_grid(uv, columns=ROWS, rows=COLUMNS)
    assert (index == np.rot90(where)).all() or (index == np.rot90(where, -1)).all()


REFUSED = {
    "larger": (dict(columns=COLUMNS - 1, rows=ROWS), "larger than 15 rows × 19 columns: it has another column"),
    "smaller": (dict(columns=COLUMNS, rows=ROWS + 1), "of its row .* only 0 of 20: the grid .* smaller or cut"),
    "far too many": (dict(columns=40, rows=30), "300 form a grid, and one of 30 rows × 40 columns has 1200"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_another_grid_than_told_is_refused(case):
    asked, words = REFUSED[case]
    with pytest.raises(KinemarkError, match=words):
        order_grid(seen(camera(roll=10))[0], **asked)


def test_a_part_of_the_grid_is_refused_as_a_whole_and_taken_as_a_part():
    uv, _ = seen(camera(away=20, roll=7, lens=(-0.1, 0, 0, 0, 0)))
    uv = uv[((uv > 0) & (uv < SIZE)).all(1) & (uv[:, 0] > 500)]
    with pytest.raises(KinemarkError, match=r"Check the numbers of rows and columns|smaller or cut"):
        order_grid(uv, columns=COLUMNS, rows=ROWS)
    index = part_of_grid(uv)
    assert (index >= 0).sum() == len(uv)
    there = index >= 0
    node = np.argwhere(there)[:, ::-1].astype(float)
    plane = undistort(camera(away=20, roll=7, lens=(-0.1, 0, 0, 0, 0)), uv[index[there]])
    affine = np.linalg.lstsq(np.column_stack([node, np.ones(len(node))]), plane)[0]
    assert np.abs(np.column_stack([node, np.ones(len(node))]) @ affine - plane).max() < 1e-6
    assert affine[0, 0] > 0 and np.linalg.det(affine[:2]) > 0


NO_GRID = {
    "nothing": np.zeros((0, 2)),
    "one": np.ones((1, 2)),
    "all at one place": np.ones((40, 2)),
    "a line": np.arange(40.0)[:, None] * [3.0, 4.0],
    "chance": np.random.default_rng(2).uniform(0, 1000, (300, 2)),
    "unseen": np.full((300, 2), np.nan),
    "too many": np.random.default_rng(2).uniform(0, 1000, (5001, 2)),
}


@pytest.mark.parametrize("case", NO_GRID)
def test_where_there_is_no_grid_none_is_found(case):
    with pytest.raises(KinemarkError, match=r"Check the|Raise the threshold"):
        order_grid(NO_GRID[case], columns=COLUMNS, rows=ROWS)
    if case != "chance":  # nine of 300 points may look like a grid
        with pytest.raises(KinemarkError, match=r"no grid|some hundred"):
            part_of_grid(NO_GRID[case])


def test_wrong_calls_are_refused():
    with pytest.raises(ValueError, match="columns and rows are 2 and 15"):
        order_grid(np.zeros((9, 2)), columns=2, rows=15)
    with pytest.raises(ValueError, match=r"uv has shape \(9, 3\)"):
        order_grid(np.zeros((9, 3)), columns=3, rows=3)
    with pytest.raises(ValueError, match="wanted"):
        part_of_grid(np.zeros(9))


def test_the_papers_300_points_are_found_in_a_picture():
    """KISS 3.2: 15 × 20 retro-reflective points at close range through a barrel lens, out of focus; exactly 300."""
    xyz = dot_grid(ROWS, COLUMNS, pitch_mm=50.0, radius_mm=6.0).xyz[:, 0]
    lens = (-0.30, 0.1, 5e-4, -3e-4, 0)
    cam = look_at("cam", (8, -1060, 5), (0, 0, 0), roll_deg=2.0, focal_px=1300.0, size=SIZE, distortion=lens)
    image = gaussian_filter(render(cam, xyz, 6.0, rng=np.random.default_rng(1)).astype(float), 2.0)
    image = np.clip(image + np.random.default_rng(2).normal(0, 3, image.shape), 0, 255).astype(np.uint8)
    blobs = detect_frames(image[None], method=Centroids())
    uv = blobs.uv[blobs.validity == 0]
    assert len(uv) == 300
    index = order_grid(uv, columns=COLUMNS, rows=ROWS)
    assert np.abs(uv[index.ravel()] - project(cam, xyz)).max() < 0.15


def board(H, *, columns=9, rows=6, size=(640, 480), blur=0.8, noise=2.0, levels=(40, 210), seed=0):
    """A chessboard under the homography H (board to px), grey on grey, and its inner corners (rows, columns, 2)."""
    over = 4
    v, u = np.mgrid[: over * size[1], : over * size[0]]
    place = np.stack([(u + 0.5) / over - 0.5, (v + 0.5) / over - 0.5, np.ones(u.shape)], -1) @ np.linalg.inv(H).T
    x, y = place[..., 0] / place[..., 2], place[..., 1] / place[..., 2]
    inside = (x > -1) & (x < columns) & (y > -1) & (y < rows)
    dark = inside & ((np.floor(x) + np.floor(y)) % 2 == 0)
    fine = np.where(dark, levels[0], levels[1]).astype(float)
    image = gaussian_filter(fine.reshape(size[1], over, size[0], over).mean((1, 3)), blur)
    image = image + np.random.default_rng(seed).normal(0, noise, image.shape)
    node = np.stack([*np.meshgrid(np.arange(columns), np.arange(rows)), np.ones((rows, columns))], -1) @ H.T
    return np.clip(image, 0, 255).astype(np.uint8), node[..., :2] / node[..., 2:]


SLANTED = np.array([[42.0, -6.0, 130.0], [7.0, 38.0, 110.0], [3e-2, -1e-2, 1.0]])


@pytest.fixture(scope="module")
def slanted():
    return board(SLANTED)


def test_corners_are_where_they_are(slanted):
    image, true = slanted
    off = find_corners(image, columns=9, rows=6) - true
    assert np.sqrt((off**2).sum(-1).mean()) < 0.05
    assert np.abs(off.mean((0, 1))).max() < 0.01


def test_corners_do_not_depend_on_grey_levels(slanted):
    image, _ = slanted
    corners = find_corners(image, columns=9, rows=6)
    for other in ((255 - image).astype(np.uint16) * 257, image / 255.0):
        assert find_corners(other, columns=9, rows=6) == pytest.approx(corners, abs=2e-3)


def test_a_board_upside_down_or_mirrored_is_read_like_a_page(slanted):
    image, _ = slanted
    corners = find_corners(image, columns=9, rows=6)
    far = np.array(image.shape[::-1]) - 1.0
    turned = find_corners(image[::-1, ::-1], columns=9, rows=6)
    assert far - turned[::-1, ::-1] == pytest.approx(corners, abs=1e-3)
    mirrored = find_corners(image[:, ::-1], columns=9, rows=6)
    mirrored[..., 0] = far[0] - mirrored[..., 0]
    assert mirrored[:, ::-1] == pytest.approx(corners, abs=1e-3)


def test_a_hidden_corner_is_missing_and_the_others_stay(slanted):
    image, true = slanted
    hidden = image.copy()
    u, v = np.rint(true[2, 4]).astype(int)
    hidden[v - 12 : v + 13, u - 12 : u + 13] = 125
    corners = find_corners(hidden, columns=9, rows=6)
    assert np.isnan(corners[2, 4]).all()
    near = np.linalg.norm(true - true[2, 4], axis=-1) < 50
    assert np.abs(corners - true)[~near].max() < 0.2


def test_a_corner_whose_squares_are_the_wrong_way_round_is_no_corner(slanted):
    image, true = slanted
    painted = image.copy()
    u, v = np.rint(true[2, 4]).astype(int)
    painted[v - 14 : v + 15, u - 14 : u + 15] = 250 - painted[v - 14 : v + 15, u - 14 : u + 15]
    corners = find_corners(painted, columns=9, rows=6)
    assert np.isnan(corners[2, 4]).all()
    assert np.isfinite(corners).all(-1).sum() > 45


def marks(columns, rows, pitch=36.0):
    """Marks of two dark and two bright quarters, the same way round everywhere, as surveyors use them."""
    v, u = np.mgrid[: int(pitch * rows), : int(pitch * columns)]
    x, y = u % pitch - pitch / 2 + 0.3, v % pitch - pitch / 2 + 0.3
    return gaussian_filter(128 + 90 * np.sign(x * y) * (np.hypot(x, y) < 13), 0.8)


NO_BOARD = {
    "marks": marks(9, 6),
    "dark": np.zeros((120, 160), np.uint8),
    "white": np.full((120, 160), 255, np.uint8),
    "noise": np.random.default_rng(0).integers(0, 255, (120, 160)),
    "stripes": np.tile(np.repeat([0, 255], 8), (120, 10)),
}


@pytest.mark.parametrize("case", NO_BOARD)
def test_where_there_is_no_board_none_is_found(case):
    with pytest.raises(KinemarkError, match="No chessboard of 6 × 9 inner corners is found"):
        find_corners(NO_BOARD[case], columns=9, rows=6)


@pytest.mark.parametrize(("columns", "rows"), [(8, 6), (10, 6), (9, 7)])
def test_a_board_of_another_size_is_refused(slanted, columns, rows):
    with pytest.raises(KinemarkError, match=f"No chessboard of {rows} × {columns}"):
        find_corners(slanted[0], columns=columns, rows=rows)


def test_a_colour_picture_is_refused():
    with pytest.raises(ValueError, match=r"image has shape \(20, 20, 3\), wanted \(height, width\)"):
        find_corners(np.zeros((20, 20, 3)), columns=9, rows=6)


def same_order(ours, theirs):
    """OpenCV's corners, which may begin at the other end."""
    return theirs if np.abs(ours - theirs).max() < np.abs(ours - theirs[::-1, ::-1]).max() else theirs[::-1, ::-1]


def test_corners_are_no_worse_than_opencvs(slanted):
    cv2 = pytest.importorskip("cv2")
    criteria = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 60, 1e-4)
    squares = np.zeros(2)
    for image, true in (slanted, board(SLANTED + np.diag([4.0, 3.0, 0.0]), seed=1, noise=4)):
        found, theirs = cv2.findChessboardCorners(image, (9, 6))
        assert found
        theirs = cv2.cornerSubPix(image, theirs, (5, 5), (-1, -1), criteria).reshape(6, 9, 2)
        ours = find_corners(image, columns=9, rows=6)
        squares += [((at - true) ** 2).sum(-1).mean() for at in (ours, same_order(ours, theirs))]
    assert squares[0] <= 1.05 * squares[1]


def test_real_chessboards_agree_with_opencv():
    cv2 = pytest.importorskip("cv2")
    criteria = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 60, 1e-4)
    off = []
    for path in sorted(shared_data("cameras/chessboard_left").glob("*.jpg"))[::4]:
        image = read_image(path).astype(np.uint8)
        found, theirs = cv2.findChessboardCorners(image, (9, 6))
        assert found
        theirs = cv2.cornerSubPix(image, theirs, (5, 5), (-1, -1), criteria).reshape(6, 9, 2)
        ours = find_corners(image, columns=9, rows=6)
        assert np.isfinite(ours).all()
        off.append(np.linalg.norm(ours - same_order(ours, theirs), axis=-1))
    assert np.median(off) < 0.1
    assert np.quantile(off, 0.95) < 0.4


FAR, NEAR = (150.0, 60.0, 700.0), (230.0, 0.0, 300.0)


def body(rng, place=FAR):
    """(60, 3) mm: a body with dots on three levels, and a camera before it."""
    x, y = np.meshgrid(np.arange(10) * 12.0, np.arange(6) * 12.0)
    z = 10.0 * (np.arange(10) % 3) * np.ones((6, 1))
    focal, roll = 3.5 * np.linalg.norm(place), float(rng.uniform(-90, 90))
    cam = look_at("c", place, (55.0, 30.0, 0.0), roll_deg=roll, focal_px=focal, size=SIZE)
    return np.stack([x, y, z], -1).reshape(-1, 3), cam


@pytest.mark.parametrize(
    ("picked", "place"),
    [((0, 9, 50, 59), FAR), ((0, 9, 59), FAR), ((0, 4, 8, 50, 55, 59), FAR), ((0, 4, 8, 50, 55, 59), NEAR)],
)
def test_dots_of_a_body_are_named_from_a_few_picked_by_hand(picked, place):
    """Three; four in a plane; six on two lines, which alone leave the perspective open; and from close by."""
    rng = np.random.default_rng(len(picked))
    xyz, cam = body(rng, place)
    true = project(cam, xyz)
    uv = np.concatenate([true + rng.normal(0, 0.2, true.shape), rng.uniform(0, 1000, (8, 2))])
    uv = uv[np.arange(len(uv)) != 33]
    at = true[list(picked)] + rng.uniform(-6, 6, (len(picked), 2))
    index = assign_points(uv, xyz, picked=np.array(picked), at=at)
    assert index[33] == -1
    wanted = np.arange(60) - (np.arange(60) > 33)
    assert (np.delete(index, 33) == np.delete(wanted, 33)).all()


def test_points_picked_too_few_from_close_by_are_refused_and_never_name_dots_wrongly():
    """Four in a plane, three, and six that do span space: a level of the body may look like its neighbour."""
    named = {}
    for picked in ((0, 9, 50, 59), (0, 9, 59), (0, 7, 14, 44, 50, 59)):
        named[picked] = 0
        for seed in range(12):
            rng = np.random.default_rng(seed)
            xyz, cam = body(rng, NEAR)
            true = project(cam, xyz)
            uv = np.concatenate([true + rng.normal(0, 0.2, true.shape), rng.uniform(0, 1000, (8, 2))])
            at = true[list(picked)] + rng.uniform(-6, 6, (len(picked), 2))
            try:
                index = assign_points(uv, xyz, picked=np.array(picked), at=at)
            except KinemarkError as error:
                assert "Pick more points, off one plane" in str(error)
                continue
            named[picked] += 1
            assert np.linalg.norm(uv[index] - true, axis=1)[index >= 0].max() < 3
    assert named[(0, 9, 59)] < 12
    assert named[(0, 7, 14, 44, 50, 59)] >= 11


def test_a_body_that_is_not_there_or_picked_badly_is_refused():
    xyz, cam = body(np.random.default_rng(1))
    uv = project(cam, xyz)
    with pytest.raises(KinemarkError, match="of the target's 60 points are found"):
        assign_points(uv[:10], xyz, picked=np.array([0, 9, 50, 59]), at=uv[[0, 9, 50, 59]])
    with pytest.raises(KinemarkError, match="not on one line"):
        assign_points(uv, xyz, picked=np.array([0, 3, 6]), at=uv[[0, 3, 6]])
    with pytest.raises(ValueError, match="wanted"):
        assign_points(uv, xyz, picked=np.array([0, 3, 6]), at=uv[:2])
    with pytest.raises(ValueError, match="tolerance"):
        assign_points(uv, xyz, picked=np.array([0, 9, 59]), at=uv[[0, 9, 59]], tolerance=0.0)


def test_all_dots_of_a_real_target_are_named():
    """`dot_target_4cam`, camera 2: 95 dots from the four that were picked by hand; published DLT 0.12 to 0.15 px."""
    folder = shared_data("cameras/dot_target_4cam")
    xyz = np.loadtxt(folder / "cal" / "target_on_a_side2.txt")[:, 1:]
    corners = np.array([(-67.5, 30), (67.5, 30), (-67.5, -30), (67.5, -30)])
    picked = np.array([np.abs(xyz[:, :2] - corner).sum(1).argmin() for corner in corners])
    image = read_image(folder / "cal" / "cam2.tif")
    blobs = detect_frames(image[None], method=Centroids(min_area=50, max_discs=1, correct_occlusion=False))
    uv = blobs.uv[blobs.validity == 0]
    index = assign_points(uv, xyz, picked=picked, at=np.loadtxt(folder / "man_ori.dat")[:4])
    assert (index >= 0).all() and len(set(index)) == 95
    h = np.column_stack([xyz, np.ones(95)]) @ from_dlt(fit_dlt(xyz, uv[index])).T
    assert np.sqrt(((h[:, :2] / h[:, 2:] - uv[index]) ** 2).sum(1).mean()) < 0.15
