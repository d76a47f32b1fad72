"""Claims: what a stretch of path is called, found again by its witnesses."""

from dataclasses import replace

import numpy as np
import pytest

from kinemark.data import MarkerTrajectory, Trajectories, same
from kinemark.data.edits import FEWEST_WITNESSES, Claim, Undo
from kinemark.data.track_trajectories import trajectories_of
from kinemark.edit import replay, stretch_of
from kinemark.engine.editing.editing import Editing
from kinemark.engine.editing.journal import Journal
from kinemark.engine.editing.makers import claim as claim_of
from kinemark.engine.keys import world_key
from kinemark.track.simultaneous import track_detections
from support.edited import FRAMES, entries, paths_without_images, samples, scene


def claim(name, called, trajectories=None, **where):
    _, detections, tracks, world = scene()
    if trajectories is not None:
        return Claim(stretch_of(trajectories, name, **where), called)
    return Claim(stretch_of(tracks, name, detections=detections, world=world, **where), called)


def replayed(said, **other):
    rig, detections, tracks, world = scene()
    return replay(
        other.get("trajectories", tracks), said, detections=detections, rig=rig, world=other.get("world", world)
    )


def outcomes(edited):
    return [one.outcome for one in edited.applied]


def test_nothing_said_changes_nothing():
    tracks = scene()[2]
    assert replayed([]).trajectories is tracks
    assert replayed(entries(claim("*1", "A"), Undo(1))).trajectories is tracks


def test_replay_is_the_same_each_time_and_shares_what_it_does_not_change():
    said = entries(claim("*1", "A"), claim("*2", None, first=20, last=40))
    one, two = replayed(said), replayed(said)
    assert same(one.trajectories, two.trajectories) and one.applied == two.applied
    assert one.trajectories["*3"] is scene()[2]["*3"]


def test_witnesses_are_spread_over_the_stretch_with_both_ends_and_the_place_pointed_at():
    _, detections, tracks, world = scene()
    where = stretch_of(tracks, "*1", first=10, at=44, detections=detections, world=world)
    frames = [witness.frame for witness in where.witnesses]
    seen = np.flatnonzero(tracks["*1"].origin > 0) + 1
    assert len(frames) <= FEWEST_WITNESSES and frames[0] == max(10, seen[0]) and frames[-1] == seen[-1] and 44 in frames
    assert np.diff(frames).max() <= np.ceil((seen[-1] - 10) / (FEWEST_WITNESSES - 2))
    assert all(len(witness.images) >= 2 for witness in where.witnesses)


def test_a_long_path_that_comes_in_pieces_keeps_its_name_in_all_of_them():
    whole = paths_without_images(frames=1300)
    said = entries(Claim(stretch_of(whole, "*1"), "A"))
    pieces = []
    for k, first in enumerate(range(0, 1300, 30)):  # as another tracker may leave it
        xyz = np.full((1300, 3), np.nan)
        xyz[first : first + 27] = whole["*1"].xyz[first : first + 27]
        pieces.append(MarkerTrajectory.measured(f"*{k + 10}", xyz))
    found = samples(replay(replace(whole, paths=(*pieces, *whole.paths[1:])), said).trajectories)
    assert len(found["A"]) > 0.95 * sum(np.isfinite(path.xyz[:, 0]).sum() for path in pieces)


def test_a_name_may_be_given_to_all_to_a_part_and_taken_away():
    tracks = scene()[2]
    whole = samples(replayed(entries(claim("*1", "A"))).trajectories)
    assert np.array_equal(whole["A"], samples(tracks)["*1"]) and "*1" not in whole
    part = samples(replayed(entries(claim("*1", "A", first=31, last=60))).trajectories)
    assert part["A"].tolist() == list(range(30, 60))
    assert part["*1"].max() < 30 and part["*6"].min() >= 60, (
        "what is before and after is two tracks, not one with a gap"
    )
    spike = samples(replayed(entries(claim("*1", None, first=31, last=33))).trajectories)
    kept = np.setdiff1d(whole["A"], [30, 31, 32])
    assert len(spike) == len(tracks) and np.array_equal(spike["*1"], kept), "what is no marker parts no track"
    ghost = samples(replayed(entries(claim("*1", None))).trajectories)
    assert "*1" not in ghost and len(ghost) == len(tracks) - 1


def test_later_claims_win_where_both_speak():
    said = entries(claim("*1", "A"), claim("*1", "B", first=61))
    edited = replayed(said)
    found = samples(edited.trajectories)
    assert found["A"].max() == 59 and found["B"].min() == 60 and outcomes(edited) == ["held", "held"]
    over = replayed(entries(claim("*1", "A"), claim("*1", "B")))
    assert outcomes(over) == ["overruled", "held"] and "A" not in over.trajectories.names
    back = replayed(entries(claim("*1", "A"), claim("*1", "B"), Undo(2)))
    assert "A" in back.trajectories.names and "B" not in back.trajectories.names


def test_an_exchange_is_two_claims_and_may_be_said_in_either_order():
    tracks = scene()[2]
    names = replayed(entries(claim("*1", "A"), claim("*2", "B"))).trajectories
    _, detections, _, world = scene()

    def other(one, two):
        return Claim(stretch_of(names, one, first=61, detections=detections, world=world), two)

    said = entries(claim("*1", "A"), claim("*2", "B"))
    for swap in ((other("A", "B"), other("B", "A")), (other("B", "A"), other("A", "B"))):
        found = replayed([*said, *entries(swap, first=3)]).trajectories
        assert np.array_equal(found["A"].xyz[60:], tracks["*2"].xyz[60:], equal_nan=True)
        assert np.array_equal(found["A"].xyz[:60], tracks["*1"].xyz[:60], equal_nan=True)
        assert np.array_equal(found["B"].xyz[60:], tracks["*1"].xyz[60:], equal_nan=True)


def test_one_name_has_one_place_a_frame_and_what_gives_way_is_unnamed():
    edited = replayed(entries(claim("*1", "A"), claim("*2", "A", first=50)))
    found, tracks = samples(edited.trajectories), scene()[2]
    assert np.array_equal(edited.trajectories["A"].xyz[49:], tracks["*2"].xyz[49:], equal_nan=True)
    assert found["*6"].min() == 49, "the earlier claim's samples are kept, unnamed"
    assert sum(map(len, found.values())) == sum(map(len, samples(tracks).values()))


def test_pieces_of_one_marker_are_joined_by_one_name():
    whole = paths_without_images()
    one, rest = whole.paths[0], whole.paths[1:]
    xyz = one.xyz.copy()
    xyz[90:110] = np.nan
    first, second = xyz.copy(), xyz.copy()
    first[90:], second[:90] = np.nan, np.nan
    broken = replace(
        whole, paths=(*(MarkerTrajectory.measured(f"*{k}", x) for k, x in ((1, first), (9, second))), *rest)
    )
    said = entries(claim("*1", "A", broken), claim("*9", "A", broken))
    edited = replay(broken, said)
    assert np.array_equal(edited.trajectories["A"].xyz, xyz, equal_nan=True) and outcomes(edited) == ["held", "held"]


def shuffled(trajectories, seed=3):
    """The same paths, numbered otherwise."""
    order = np.random.default_rng(seed).permutation(len(trajectories))
    paths = [replace(trajectories.paths[k], name=f"*{i + 1}") for i, k in enumerate(order)]
    return replace(trajectories, paths=tuple(paths))


def test_a_claim_follows_its_marker_whatever_number_its_track_has():
    tracks = scene()[2]
    said = entries(claim("*1", "A"), claim("*4", "B", first=20, last=90))
    straight, crooked = replayed(said), replayed(said, trajectories=shuffled(tracks))
    for name in ("A", "B"):
        assert np.array_equal(straight.trajectories[name].xyz, crooked.trajectories[name].xyz, equal_nan=True)


def test_images_carry_claims_into_another_world_where_places_say_nothing():
    rig, detections, tracks, _ = scene()
    R = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    cameras = tuple(replace(c, R=c.R @ R.T, t=c.t - c.R @ R.T @ [500.0, 0.0, 0.0]) for c in rig)
    moved = replace(rig, cameras=cameras, volume=np.full((2, 3), np.nan))
    again = trajectories_of(track_detections(detections, moved))
    assert world_key(moved) != world_key(rig)
    edited = replay(again, entries(claim("*1", "A")), detections=detections, rig=moved, world=world_key(moved))
    there = tracks["*1"].xyz @ R.T + [500.0, 0.0, 0.0]
    assert outcomes(edited) == ["held"] and np.nanmax(np.abs(edited.trajectories["A"].xyz - there)) < 1.0
    without = Claim(
        replace(
            claim("*1", "A").where, witnesses=tuple(w._replace(images=()) for w in claim("*1", "A").where.witnesses)
        ),
        "A",
    )
    lost = replay(again, entries(without), detections=detections, rig=moved, world=world_key(moved))
    assert outcomes(lost) == ["orphan"] and lost.trajectories is again


def test_places_carry_claims_where_there_are_no_images():
    whole = paths_without_images()
    noisy = [replace(p, xyz=p.xyz + np.random.default_rng(k).normal(0, 1.0, p.xyz.shape)) for k, p in enumerate(whole)]
    again = shuffled(replace(whole, paths=tuple(noisy)))
    edited = replay(again, entries(claim("*2", "A", whole)))
    assert outcomes(edited) == ["held"]
    assert np.abs(edited.trajectories["A"].xyz - whole["*2"].xyz).max() < 6.0


def test_a_claim_whose_marker_is_gone_is_an_orphan_and_names_nothing_else():
    _, _, tracks, _ = scene()
    gone = replace(tracks, paths=tracks.paths[1:])
    edited = replayed(entries(claim("*1", "A")), trajectories=gone)
    assert outcomes(edited) == ["orphan"] and edited.applied[0].reason and edited.trajectories is gone


def test_a_claim_of_which_little_is_left_is_thin():
    tracks = scene()[2]
    xyz = tracks.paths[0].xyz.copy()
    xyz[: 3 * FRAMES // 4] = np.nan
    rest = MarkerTrajectory.measured(
        "*1", xyz, detection=tracks.paths[0].detection * np.isfinite(xyz[:, :1]) - np.isnan(xyz[:, :1])
    )
    edited = replayed(entries(claim("*1", "A")), trajectories=replace(tracks, paths=(rest, *tracks.paths[1:])))
    assert outcomes(edited) == ["thin"] and 0 < edited.applied[0].share < 0.8
    assert "A" in edited.trajectories.names


def test_a_cropped_trial_takes_the_part_of_the_claims_that_it_has():
    rig, detections, _, world = scene()
    part = detections.frames(40, 100)
    tracks = replace(trajectories_of(track_detections(part, rig)), first_frame=41)
    said = entries(claim("*1", "A"), claim("*2", "B", first=1, last=30))
    edited = replay(tracks, said, detections=part, rig=rig, world=world)
    whole = scene()[2]["*1"].xyz[40:100]
    assert outcomes(edited) == ["held", "moot"]
    assert np.nanmax(np.abs(edited.trajectories["A"].xyz - whole)) < 1.0


def test_a_claim_ends_where_its_own_witnesses_deny_the_path():
    """A track that changes over to another marker after the last place where the claim was found."""
    whole = paths_without_images()
    a, b = whole.paths[:2]
    xyz = np.where(np.arange(200)[:, None] < 100, a.xyz, b.xyz)
    other = np.where(np.arange(200)[:, None] < 100, b.xyz, np.nan)
    swapped = Trajectories(tuple(MarkerTrajectory.measured(n, x) for n, x in (("*1", xyz), ("*2", other))), whole.rate)
    edited = replay(swapped, entries(claim("*1", "A", whole)))
    assert outcomes(edited) == ["thin"]
    step = int(np.diff([w.frame for w in claim("*1", "A", whole).where.witnesses]).max())
    assert samples(edited.trajectories)["A"].max() < 100 + step


def test_what_is_called_so_already_is_moot():
    whole = paths_without_images()
    named = replace(whole, paths=(replace(whole.paths[0], name="A"), *whole.paths[1:]))
    edited = replay(named, entries(claim("*1", "A", whole)))
    assert outcomes(edited) == ["moot"] and edited.trajectories["A"].xyz is named["A"].xyz


@pytest.mark.parametrize("seed", range(3))
def test_no_sample_is_lost_or_doubled_by_claims(seed):
    rng = np.random.default_rng(seed)
    whole = paths_without_images(n=6, seed=seed)
    said = []
    for _ in range(12):
        a, b = sorted(rng.integers(1, 200, 2).tolist())
        said.append(claim(f"*{rng.integers(1, 7)}", f"N{rng.integers(1, 5)}", whole, first=a, last=b))
    found = replay(whole, entries(*said)).trajectories
    before, after = (np.sort(t.xyz[np.isfinite(t.xyz[..., 0])], axis=0) for t in (whole, found))
    assert np.array_equal(before, after) and len(set(found.names)) == len(found)


def test_a_joined_trajectory_is_renamed_whole_though_its_pieces_overlap(tmp_path):
    """Nothing keeps what it was called between, and what a name was joined to is claimed as well."""
    whole = paths_without_images(n=3)
    path, rng = whole.paths[0], np.random.default_rng(1)
    one, other = path.xyz.copy(), path.xyz + rng.normal(3.0, 0.2, path.xyz.shape)
    one[104:], other[:100] = np.nan, np.nan
    pieces = MarkerTrajectory.measured("*1", one), MarkerTrajectory.measured("*9", other)
    editing = Editing(
        "t", Journal.of(tmp_path, "t"), replace(whole, paths=(*pieces, *whole.paths[1:])), None, None, "op"
    )
    editing.say(*claim_of(editing, "*1", "track1"), *claim_of(editing, "*9", "track1"))
    editing.claim("track1", "LKNE")
    names = editing.edited().trajectories
    assert "track1" not in names.names and (names["LKNE"].origin > 0).all()
    rest = [path for path in names if path.name not in ("LKNE", "*2", "*3")]
    assert sum(int((path.origin > 0).sum()) for path in rest) == 4, "one sample of each frame in which both were there"


def test_who_claims_a_piece_for_a_name_claims_what_has_it_and_goes_on(tmp_path):
    whole = paths_without_images(n=3)
    one, other = whole.paths[0].xyz.copy(), whole.paths[0].xyz.copy()
    one[100:], other[:101] = np.nan, np.nan
    pieces = MarkerTrajectory.measured("LKNE", one), MarkerTrajectory.measured("*9", other)
    editing = Editing(
        "t", Journal.of(tmp_path, "t"), replace(whole, paths=(*pieces, *whole.paths[1:])), None, None, "op"
    )
    assert [edit.name for edit in claim_of(editing, "*9", "LKNE")] == ["LKNE", "LKNE"]
    assert len(claim_of(editing, "*2", "LKNE")) == 1, "a marker elsewhere is not the same one"
    assert len(claim_of(editing, "*9", "RKNE")) == 1


def test_a_claim_whose_path_was_another_marker_for_some_frames_is_thin():
    """Two markers 20 mm apart were exchanged between two witnesses, where one of them was lost: no step tells of it."""
    one = paths_without_images(n=1).paths[0]
    other = replace(one, name="*2", xyz=one.xyz + np.array([20.0, 0, 0]))
    given = replace(paths_without_images(n=1), paths=(one, other))
    said = [Claim(stretch_of(given, track, at=100), name) for track, name in (("*1", "A"), ("*2", "B"))]
    assert [one.outcome for one in replay(given, entries(*said)).applied] == ["held", "held"]
    a, b = one.xyz.copy(), other.xyz.copy()
    a[92:108], b[92:112] = b[92:108].copy(), np.nan
    again = replace(given, paths=tuple(MarkerTrajectory.measured(n, x) for n, x in (("*1", a), ("*2", b))))
    first = replay(again, entries(*said)).applied[0]
    assert first.outcome == "thin" and first.share > 0.8 and "may be those of a marker near by" in first.reason
    later = Claim(stretch_of(given, "*1", first=100), "C")
    assert "thin" not in [one.outcome for one in replay(given, entries(*said, later)).applied], "spans tell the samples"
