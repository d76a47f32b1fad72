"""A file without names beside a labelled trial of the subject: named by mouse, left and right, and written."""

import re

import numpy as np

from kinemark.data import MarkerTrajectory, Trajectories, Trial
from kinemark.io.trial import read_trial, write_trial
from support.axe import needed_axe, violations
from support.named_sessions import walk
from support.studio_page import Studio, served, window

LEFT, RIGHT = "LTOE", "RTOE"
"""Markers that are named; the left one is in two pieces."""


def files(folder):
    """A labelled trial, and another of the subject without names; gives the name of each of its tracks."""
    whole = walk(1, 1100.0, 0.8, 1.0).trajectories
    half = whole.n_frames // 2
    write_trial(Trial("known", whole.frames(0, half)), folder / "known.c3d")
    rest, paths, names = whole.frames(half, whole.n_frames), [], {}
    for path in rest:
        for low, stop in [(0, 12), (14, rest.n_frames)] if path.name == LEFT else [(0, rest.n_frames)]:
            xyz = np.full_like(path.xyz, np.nan)
            xyz[low:stop] = path.xyz[low:stop]
            names[f"*{len(paths)}"] = path.name
            paths.append(MarkerTrajectory.measured(f"*{len(paths)}", xyz))
    write_trial(Trial("raw", Trajectories(tuple(paths), rest.rate)), folder / "raw.c3d")
    return names


def test_a_nameless_file_is_named_exchanged_and_written(tmp_path, chromium_running):
    needed_axe()
    names = files(tmp_path)
    with served(tmp_path) as server:
        context = window(chromium_running, bypass_csp=True)
        studio = Studio(context, server).enter(server.address)
        page = studio.open("labels", trial="raw.c3d").page
        page.get_by_text("A file has no marker set of its own").wait_for()
        page.get_by_role("button", name=re.compile("^Propose names")).click()
        page.get_by_text("Names are proposed by known.c3d.").wait_for()
        figure = page.get_by_role("region", name="Marker set")
        assert figure.get_by_role("button", name=LEFT, exact=True).count() == 1, "all names of the trial beside it"
        assert "15 without a track" in figure.inner_text()
        tracks = [track for track, name in names.items() if name in (LEFT, RIGHT)]
        for track in tracks:
            name_by_mouse(studio, page, track, names[track])
            current = page.locator("[data-track][aria-current=true]").get_attribute("data-track")
            assert current.startswith("*") and current not in tracks[: tracks.index(track) + 1], (
                "the next comes by itself"
            )
        assert "13 without a track" in figure.inner_text()
        before = edits(studio)
        page.get_by_role("button", name=re.compile("^Exchange left and right")).click()
        page.get_by_text("Left and right exchanged.").wait_for()
        studio.press("Control+z")
        page.get_by_text("Undone.").wait_for()
        assert edits(studio) == before
        assert violations(page) == []
        studio.press("Shift+F")
        page.get_by_role("button", name="Finish and write").click()
        page.get_by_text(re.compile("^Written: ")).wait_for()
        assert studio.errors == []
        context.close()
    (written,) = (file for file in tmp_path.glob("*.c3d") if file.name not in ("known.c3d", "raw.c3d"))
    assert set(read_trial(written).trajectories.names) == {LEFT, RIGHT}


def name_by_mouse(studio, page, track, name):
    """A click on the track, and one on its name in the list of all names."""
    before = studio.head
    page.locator(f"[data-track='{track}'] button").first.click()
    if page.locator(f"[data-track={name}]").count():
        studio.press("l")  # the other piece has it: a click would look at that
        page.get_by_role("option", name=re.compile(f"^{name}")).click()
    else:
        page.get_by_role("region", name="Marker set").get_by_role("button", name=name, exact=True).click()
    page.locator(f"main:not([data-head='{before}'])").wait_for()
    page.locator(f"[data-track='{track}']").wait_for(state="detached")


def edits(studio):
    return studio.page.locator("main").get_attribute("data-edits")
