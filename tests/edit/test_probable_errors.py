"""Errors of paths are found where they are, with probabilities that tell them from what is right."""

from dataclasses import replace

import numpy as np
import pytest

from kinemark.data import MarkerTrajectory, Trajectories
from kinemark.data.edits import is_named
from kinemark.edit.probable_errors import Paths, Told, changes, ghosts, in_trial, leaps, pieces, places, spikes
from kinemark.edit.probable_errors.companion_steps import companion_steps
from kinemark.edit.probable_errors.paths import HALF, Ends, continued, ends, meeting
from kinemark.edit.probable_errors.places import APART_S, PARTNERS, REACH_MM, REACH_SPEED
from kinemark.edit.probable_errors.probability import BEYOND, COEFFICIENTS, TAIL, UNLIKELY, as_common, evidence_of_trial
from kinemark.edit.probable_errors.shape import companions, spread
from kinemark.signal.filters import butterworth
from support.walked import RATE, clean, every, exchanged, nearest, spiked, trajectories, walk, with_xyz, without


def changes_of(trial):
    paths = Paths.of(trial)
    return changes(paths, places(paths)), paths


def likely(trial, above=0.5):
    found, paths = changes_of(trial)
    frame = {one: int(paths.frames[one.place.path][one.place.sample + 1]) for one in found}
    return [(one.place.path, one.partner.path, frame[one], one.wrong) for one in found if one.wrong > above]


@pytest.mark.parametrize("seed", [3, 8])
def test_a_clean_walk_has_no_likely_error(seed):
    trial = clean(seed=seed)
    assert not likely(trial) and not [one for one in spikes(Paths.of(trial)) if one.wrong > 0.5]


@pytest.mark.parametrize(("p", "f"), [(4, 150), (9, 200), (15, 260)])
def test_an_exchange_of_neighbours_is_found_in_its_frame_with_its_partner(p, f):
    trial = clean()
    q = nearest(walk()[1], p, f)
    found = likely(exchanged(trial, p, q, f))
    assert found and {frame for *_, frame, _ in found} == {f}
    assert {(a, b) for a, b, *_ in found} <= {(p, q), (q, p)} and max(wrong for *_, wrong in found) > 0.9


def test_an_exchange_over_a_gap_is_told_from_a_gap_by_the_shape_of_the_body():
    trial = clean()
    p, f = 9, 200
    q = nearest(walk()[1], p, f)
    hidden = without(without(trial, p, f - 15, f + 15), q, f - 15, f + 15)
    assert not likely(hidden)
    assert {(a, b) for a, b, *_ in likely(exchanged(hidden, p, q, f))} == {(p, q), (q, p)}


@pytest.mark.parametrize("f", [21, 33, 48])
def test_an_exchange_that_fast_motion_hides_where_frames_are_few_is_found_by_the_shape_of_the_body(f):
    trial = every(clean(), 4)
    p = 8
    q = nearest(trial.xyz, p, f)
    hidden = exchanged(trial, p, q, f)
    paths = Paths.of(hidden)
    assert not any(paths.index_before(one, f - 1) in paths.jumps[one] for one in (p, q))
    assert not likely(trial) and {(a, b) for a, b, *_ in likely(hidden, 0.8)} == {(p, q), (q, p)}
    assert all(len(steps) == 0 for steps in companion_steps(Paths.of(trial)))


@pytest.mark.parametrize(("p", "f"), [(4, 120), (6, 160), (8, 280), (15, 240)])
def test_a_stretch_of_some_frames_that_ends_in_a_gap_is_told_by_how_the_path_leaves_its_companions(p, f):
    """Over a second, in which the body's shape was compared, it does not show: it was told with 1 %."""
    whole = without(clean(), p, f + 3, f + 9)
    told = []
    for trial in (whole, spiked(whole, p, f, f + 3, mm=40.0)):
        found, _ = changes_of(trial)
        told.append(max(one.wrong for one in found if one.place.path == p and abs(one.place.middle - f - 5.5) < 1))
    assert told[0] < 0.05 and told[1] > 0.2


@pytest.mark.parametrize(("frames", "tells"), [(1, True), (14, True), (16, False), (60, False)])
def test_over_a_gap_in_which_a_body_bends_companions_do_not_tell(frames, tells):
    found, _ = changes_of(without(clean(), 6, 160, 160 + frames - 1) if frames > 1 else spiked(clean(), 6, 160, 170))
    (one,) = (one for one in found if one.place.path == 6 and 159 <= one.place.middle - (frames - 1) / 2 <= 160)
    assert (one.evidence.left > 0) == tells


def test_a_long_gap_by_itself_does_not_speak_for_two_markers():
    """A glove's only sample after four seconds, 3 mm from where it was, was called another marker's with 62 %."""
    whole = clean()
    standing = with_xyz(whole, {p: path.xyz[:1] + (path.xyz - path.xyz[:1]) / 1000 for p, path in enumerate(whole)})
    lone = without(without(standing, 5, 7, len(whole.paths[5].xyz) - 1), 5, 0, 2)
    assert max((wrong for p, *_, wrong in likely(lone, 0.0) if p == 5), default=0.0) < 0.05


@pytest.mark.parametrize(("first", "stop"), [(120, 121), (120, 126), (250, 252)])
def test_a_spike_is_found_with_its_samples(first, stop):
    found = [one for one in spikes(Paths.of(spiked(clean(), 6, first, stop))) if one.wrong > 0.5]
    assert [(one.path, one.first, one.last) for one in found] == [(6, first, stop - 1)]
    assert abs(found[0].keep_mm - 40) < 6 and found[0].erase_mm < 6


@pytest.mark.parametrize(("rate", "mm"), [(RATE, 40.0), (RATE / 2, 40.0), (RATE / 4, 80.0)])
def test_what_jumps_with_all_that_is_near_it_is_motion_and_alone_it_is_a_spike(rate, mm):
    trial = every(clean(), round(RATE / rate))
    at = trial.n_frames // 2
    near = np.linalg.norm(trial.xyz[:, at] - trial.xyz[6, at], axis=1).argsort()[:14].tolist()
    together = trial
    for p in near:
        together = spiked(together, p, at, at + 2, mm=mm)
    for moved, least, most in ((together, 0.0, 0.1), (spiked(trial, 6, at, at + 2, mm=mm), 0.2, 1.0)):
        (own,) = (one for one in spikes(Paths.of(moved)) if (one.path, one.first, one.last) == (6, at, at + 1))
        assert least < own.wrong < most


def smeared(trial, p, first, stop, off, frames):
    """Samples stand off, and the steps there and back go on over some frames, as filters leave them."""
    inside = np.zeros(trial.n_frames)
    inside[first:stop] = 1.0
    weight = np.hanning(frames + 2)[1:-1] / np.hanning(frames + 2).sum()
    slow = np.convolve(np.pad(inside, frames, mode="edge"), weight, mode="same")[frames:-frames]
    return with_xyz(trial, {p: trial.paths[p].xyz + slow[:, None] * np.asarray(off)})


def likely_leaps(trial, above=0.5):
    return [one for one in leaps(Paths.of(trial)) if one.wrong > above]


@pytest.mark.parametrize("frames", [1, 2, 4])
@pytest.mark.parametrize("seed", [3, 8])
def test_a_path_that_goes_over_to_another_place_within_some_frames_leaps(seed, frames):
    trial = clean(seed=seed)
    assert not likely_leaps(trial, 0.05)
    for p, f in ((4, 150), (9, 220), (15, 260)):
        (one,) = likely_leaps(smeared(trial, p, f, None, [60.0, 50.0, 0.0], frames), 0.2)
        assert one.path == p and not one.back and 40 < one.mm < 90
        assert f - frames <= one.before < f <= one.after <= f + frames and one.after - one.before <= frames + 1


def test_a_leap_that_ends_in_a_gap_is_found_on_either_side_of_it():
    whole = smeared(clean(), 6, 200, None, [80.0, 0.0, 0.0], 3)
    for first, stop in ((204, 240), (150, 190)):
        (one,) = likely_leaps(without(whole, 6, first, stop))
        assert one.path == 6 and one.before < 200 <= one.after


def test_leaps_there_and_back_are_one_whose_samples_are_wrong():
    (one,) = likely_leaps(smeared(clean(), 6, 200, 215, [0.0, 90.0, 0.0], 3))
    assert one.back and one.before < 200 and 215 <= one.after < 220


@pytest.mark.parametrize(("rate", "cutoff_hz"), [(RATE, 10.0), (RATE, 20.0), (RATE / 2, 10.0)])
def test_a_spike_that_was_filtered_is_a_leap_there_and_back(rate, cutoff_hz):
    trial = every(clean(), round(RATE / rate))
    at = trial.n_frames // 2
    off = np.zeros(trial.n_frames)
    off[at : at + 2] = 200.0
    off = butterworth(off, rate=rate, cutoff_hz=cutoff_hz)
    moved = with_xyz(trial, {6: trial.paths[6].xyz + off[:, None] * [0.0, 1.0, 0.0]})
    (one,) = likely_leaps(moved)
    wrong = np.flatnonzero(off > 0.5 * off.max())
    assert one.path == 6 and one.back and one.before < wrong[0] and wrong[-1] < one.after
    assert one.after - one.before <= len(wrong) + 5


def test_what_leaps_where_all_that_is_near_it_shakes_is_less_likely_wrong():
    trial, rng = clean(), np.random.default_rng(5)
    near = np.linalg.norm(trial.xyz[:, 200] - trial.xyz[6, 200], axis=1).argsort()[:8].tolist()
    phase = rng.uniform(0, 2 * np.pi, (len(near), 1, 3)) + 2 * np.pi * 8.0 * np.arange(trial.n_frames)[:, None] / RATE
    shaken = with_xyz(trial, {p: trial.paths[p].xyz + 2.0 * np.sin(phase[k]) for k, p in enumerate(near)})
    off = [0.0, 40.0, 0.0]
    quiet, loud = (
        max((one.wrong for one in leaps(Paths.of(smeared(of, 6, 200, None, off, 2))) if one.path == 6), default=0.0)
        for of in (trial, shaken)
    )
    assert quiet > 0.3 and 0 < loud < quiet / 2
    assert not [one for one in likely_leaps(shaken, 0.05) if one.path in near]


def test_what_leaps_with_all_that_is_near_it_is_motion():
    trial = every(clean(), 4)
    at = trial.n_frames // 2
    near = np.linalg.norm(trial.xyz[:, at] - trial.xyz[6, at], axis=1).argsort()[:14].tolist()
    together = trial
    for p in near:
        together = smeared(together, p, at, None, [0.0, 0.0, 90.0], 1)
    assert not [one for one in likely_leaps(together, 0.1) if one.path == 6]
    (alone,) = [one for one in likely_leaps(smeared(trial, 6, at, None, [0.0, 0.0, 90.0], 1), 0.2) if one.path == 6]
    assert alone.before < at <= alone.after


def test_partners_are_the_paths_whose_halves_come_nearest_by_how_far_a_marker_may_come():
    """Against the definition, said for one path at a time."""
    rng = np.random.default_rng(2)
    trial = clean()
    for p in range(0, len(trial), 2):
        first = int(rng.integers(20, 300))
        trial = without(trial, p, first, first + int(rng.integers(2, 120)))
    paths = Paths.of(trial)
    for place in places(paths):
        (f, g), shares = paths.frames[place.path][place.sample :][:2], {}
        for q, own in enumerate(paths.frames):
            before, after = own[own <= place.middle], own[own > place.middle]
            here = [(before[-1], g)] if len(before) and g - before[-1] < APART_S * RATE else []
            here += [(after[0], f)] if len(after) and after[0] - f < APART_S * RATE else []
            if q != place.path and here:
                shares[q] = min(
                    np.linalg.norm(paths.xyz[q, a] - paths.xyz[place.path, b])
                    / (REACH_MM + REACH_SPEED * abs(int(a) - int(b)) / RATE)
                    for a, b in here
                )
        nearest_four = sorted((q for q in shares if shares[q] < 1), key=shares.get)[:PARTNERS]
        assert {one.path for one in place.partners} >= {-1, *nearest_four}


def test_two_pieces_are_one_marker_in_the_order_of_time_alone():
    """Single images of a path, a few frames apart, were asked about forwards and backwards."""
    whole = clean()
    xyz = np.full((2, *whole.paths[4].xyz.shape), np.nan)
    xyz[0, 100], xyz[1, 102] = whole.paths[4].xyz[[100, 102]]
    loose = tuple(MarkerTrajectory.measured(f"*{k}", one) for k, one in enumerate(xyz))
    for some in (loose, loose[::-1]):
        found = pieces(Paths.of(replace(whole, paths=(*whole.paths[:4], *whole.paths[5:], *some))))
        names = (*whole.names[:4], *whole.names[5:], *(one.name for one in some))
        assert [(names[one.before], names[one.after]) for one in found] == [("*0", "*1")]


@pytest.mark.parametrize(("samples", "found"), [(1, False), (3, False), (40, True)])
def test_stray_images_long_after_each_other_are_no_pieces_of_a_marker(samples, found):
    """A walk's list was four pairs of single points, 0.6 to 1.1 m and half a second apart, with 20 %."""
    names, xyz = walk()
    loose = np.full((2, *xyz.shape[1:]), np.nan)
    for one, first in ((0, 100 - samples), (1, 200)):
        loose[one, first : first + samples] = xyz[9, first : first + samples]
    trial = trajectories([*np.delete(xyz, 9, 0), *loose], [*np.delete(names, 9), "*1", "*2"])
    assert bool(pieces(Paths.of(trial))) == found


def test_two_pieces_of_one_marker_are_likelier_one_than_two_of_two():
    names, xyz = walk()
    whole = np.full((1, *xyz.shape[1:]), np.nan)
    parts = {"*1": whole[0].copy(), "*2": whole[0].copy()}
    parts["*1"][:200], parts["*2"][206:] = xyz[9, :200], xyz[9, 206:]
    rest = np.delete(xyz, 9, 0)
    trial = trajectories([*rest, *parts.values()], [*np.delete(names, 9), *parts])
    best = max(pieces(Paths.of(trial)), key=lambda one: one.wrong)
    assert (trial.names[best.before], trial.names[best.after]) == ("*1", "*2") and best.wrong > 0.8
    assert best.join_mm < 20 and (best.last, best.first) == (199, 206)


def test_only_short_rough_paths_without_a_name_are_ghosts():
    names, xyz = walk()
    ghost = np.full(xyz.shape[1:], np.nan)
    ghost[100:104] = xyz[:, 100:104].mean(0) + np.random.default_rng(0).normal(0, 8, (4, 3))
    trial = trajectories([*xyz, ghost], ["*7", *names[1:], "*99"])
    found = {trial.names[one.path]: one.wrong for one in ghosts(Paths.of(trial), trial)}
    assert set(found) == {"*7", "*99"} and not any(map(is_named, found)) and found["*99"] > 10 * found["*7"]


def test_a_path_whose_rays_meet_under_a_small_angle_is_likelier_a_ghost():
    """By its stated covariance alone: a short piece of a marker that is seen as well has a small one."""
    names, xyz = walk()
    short = np.full((2, *xyz.shape[1:]), np.nan)
    short[:, 100:140] = xyz[:2, 100:140] + [[[500.0, 0.0, 0.0]], [[0.0, 500.0, 0.0]]]
    trial = trajectories([*xyz, *short], [*names, "*1", "*2"])
    cov = np.full((len(trial), xyz.shape[1], 3, 3), np.eye(3) * 0.5**2)
    cov[-1] = np.diag([20.0, 3.0, 3.0]) ** 2
    paths = tuple(replace(path, cov=one) for path, one in zip(trial, cov, strict=True))
    trial = replace(trial, paths=paths)
    marker, ghost = (one.wrong for one in ghosts(Paths.of(trial), trial))
    assert ghost > 5 * marker


def test_ends_meet_within_what_is_stated_in_half_of_all_cases():
    trial = clean()
    paths = Paths.of(trial)
    who, index = np.repeat(np.arange(len(trial)), 20), np.tile(np.linspace(30, 350, 20).astype(int), len(trial))
    met = meeting(ends(paths, who, index, -1), ends(paths, who, index + 10, 1), paths.rate, paths.q)
    assert 0.3 < np.mean(met.squared < HALF) < 0.75


def test_noise_is_that_of_the_samples_whatever_the_motion():
    names, xyz = walk()
    rng = np.random.default_rng(1)
    noisy = trajectories(xyz + rng.normal(0, 1.0, xyz.shape), names)
    assert abs(np.median(Paths.of(noisy).sd) / np.hypot(1.0, 0.2) - 1) < 0.25


def test_what_is_found_hangs_neither_on_the_origin_nor_on_the_axes():
    trial = spiked(exchanged(clean(), 9, nearest(walk()[1], 9, 200), 200), 6, 100, 102)
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    moved = with_xyz(trial, {k: path.xyz @ turn.T + [4e5, -3e5, 1e4] for k, path in enumerate(trial)})
    one, other = (sorted(round(c.wrong, 4) for c in changes_of(t)[0]) for t in (trial, moved))
    assert one == pytest.approx(other, abs=2e-3)


def test_a_minute_after_the_last_sample_of_a_smooth_path_nothing_is_known_and_nothing_fails():
    """As of a file without noise in which a marker is missing for long."""
    frame = np.arange(5.0)[None]
    end = Ends(frame, np.zeros((1, 5, 3)), np.full((1, 5), 0.05**2))
    place, variance = continued(end, np.array([12_000.0]), 100.0, 4000.0)
    assert np.isfinite(place).all() and variance[0] > 1e6
    near, _ = continued(end, np.array([6.0]), 100.0, 4000.0)
    assert np.abs(near).max() < 0.01


def test_where_there_is_no_path_nothing_is_wrong():
    paths = Paths.of(Trajectories((), RATE))
    assert not places(paths) and not leaps(paths) and not spikes(paths) and not pieces(paths)


def test_companions_say_one_marker_where_a_path_goes_on_and_not_where_it_is_another_now():
    trial = clean()
    p, f = 9, 200
    q = nearest(walk()[1], p, f)
    said = [companions(paths := Paths.of(one), p, f - 1, spread(paths)) for one in (trial, exchanged(trial, p, q, f))]
    assert said[0] > 5 and said[1] < said[0] - 5
    assert companions(Paths.of(trial), p, trial.n_frames - 2, 1000.0) == 0.0


@pytest.mark.parametrize(("near", "inside"), [(True, True), (True, False), (False, True)])
def test_a_place_tells_whether_tracking_saw_another_come_near(near, inside):
    paths = Paths.of(without(clean(), 9, 200, 206))
    frame = 203 if inside else 120
    (place,) = (one for one in places(paths, [Told(9, frame, frame, 3, near)]) if (one.path, one.sample) == (9, 199))
    assert place.near == (near and inside) and place.told == inside


def said(wrong, rate=100.0):
    return in_trial(np.array(wrong, np.float64), rate)


def test_the_other_problems_of_a_trial_tell_how_likely_one_is():
    """Where much is surely wrong more is, and what tells as much as others do in the trial is motion."""
    among_errors, restless = said([0.1, *[0.98] * 8])[0], said([0.1, *[0.1] * 30])[0]
    assert restless < 0.1 / 5 and among_errors / (1 - among_errors) > 2 * 0.1 / 0.9
    np.testing.assert_array_equal(said([]), np.zeros(0))


@pytest.mark.parametrize("wrong", [0.12, 0.2, 0.5, 0.9, 0.999])
def test_what_stands_alone_in_its_trial_is_as_likely_as_it_tells_itself(wrong):
    """Whatever its kind and the rate: no trial says of a problem what none of its other problems does."""
    for rate in (20.0, 100.0, 250.0):
        np.testing.assert_allclose(said([wrong], rate), [wrong], rtol=1e-9)


@pytest.mark.parametrize("others", [[], [0.99] * 5])
def test_what_is_unlikely_falls_faster_than_its_evidence(others):
    """What is hardly off its way is no error: odds a tenth as great by itself are less than a tenth as great, also
    among errors, and without a step where that begins."""
    odds = [said([own, *others])[0] for own in 1 / (1 + np.exp([8.0, 10.3, 12.6]))]
    odds = [one / (1 - one) for one in odds]
    assert odds[1] < odds[0] / 11 and odds[2] < odds[1] / 11
    either = said([1 / (1 + np.exp(UNLIKELY + 1e-6))])[0], said([1 / (1 + np.exp(UNLIKELY - 1e-6))])[0]
    assert abs(either[0] - either[1]) < 1e-6


def test_what_stands_out_in_a_restless_trial_stays_likely():
    """The others say how its people move; a count of all that may be wrong would call this motion too."""
    others = [0.03] * 60
    assert said([0.97, *others])[0] > 0.5 > 0.05 > said([0.1, *others])[0]


def test_what_tells_more_is_never_less_likely():
    """Of one trial, and of the same problem beside others that stay as they are."""
    rng = np.random.default_rng(0)
    for n in (2, 5, 40):
        wrong = np.sort(rng.beta(0.3, 0.6, size=n))
        assert (np.diff(said(wrong)) >= 0).all()
        assert (np.diff([said([own, *wrong])[0] for own in np.linspace(0.001, 0.999, 200)]) > 0).all()


def test_the_coefficients_of_a_trial_keep_what_tells_more_likelier():
    """The bounds of (3) and (5), within which the study fits them."""
    more, common, faster, together = COEFFICIENTS["in_trial"]
    assert more > 0 and 0 < common < TAIL and faster > 0 and together > 0


def test_motion_is_counted_of_the_others_and_at_most_as_what_one_tells_itself():
    """Against the definition, said for all pairs."""
    z = np.random.default_rng(1).normal(-2, 3, 50)
    z[7] = z[8]
    beyond = np.maximum(z[:, None] - z, 0)
    each = np.exp(np.minimum(z[:, None], z) / TAIL - beyond / BEYOND) / (1 + np.exp(z))
    np.fill_diagonal(each, 0.0)
    np.testing.assert_allclose(as_common(z), each.sum(1), atol=1e-12)


@pytest.mark.parametrize("wrong", [0.0, 1.0, 0.5])
def test_no_problem_is_evidence_of_itself(wrong):
    (_, errors, common, together), one = evidence_of_trial(np.array([wrong]), 60.0)[0], said([wrong])[0]
    assert errors == common == together == 0.0 and 0 <= one <= 1
