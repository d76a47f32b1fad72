"""In the browser alone: a session made of recordings, its balls pointed at, calibrated and run; a leap of an angle."""

import csv
import re

import numpy as np
import pytest

from kinemark.io.c3d import read_c3d
from support.screen_operator import Operator
from support.studio_page import Studio, needed, served, window

NEAR = 20.0  # mm; the closest markers are 60 mm apart
MOST_NAMED = 10  # of 15 markers, which three cameras do not all see


def recorded(folder, **scene):
    """The recordings of a simulated session, without its session.toml and what was said of it."""
    from kinemark.engine.simulate import Scene, simulate

    needed()
    simulate(folder, scene=Scene(seconds=0.4, size_px=(376, 292), focal_px=385.0, noise=1.0, cameras=3, **scene))
    (folder / "session.toml").unlink()
    return folder


def opened(chromium_running, server, **options):
    context = window(chromium_running)
    return Studio(context, server, **options).enter(server.address), context


def markers_of(file, truth):
    """Which marker each track of a file is, by where it is: what a person sees of a body."""
    found = {}
    for path in read_c3d(file).trajectories:
        there = np.flatnonzero(np.isfinite(path.xyz[:, 0]))
        apart = np.linalg.norm(truth["xyz"][:, there] - path.xyz[there], axis=-1).mean(1)
        if apart.min() < NEAR:
            found[path.name] = str(truth["names"][apart.argmin()])
    return found


def ready(page, words):
    """Until a job of the studio's own is done."""
    page.get_by_text(words).first.wait_for()


def test_from_rendered_videos_to_a_labelled_session_without_touching_a_file(tmp_path, chromium_running):
    """Folder, proposal, name, made, calibrated, run, opened, named, finished: by what the screen shows."""
    folder = recorded(tmp_path / "lab" / "monday")
    with served(tmp_path / "lab") as server:
        studio, context = opened(chromium_running, server)
        page = studio.page
        page.get_by_role("button", name="New session …").click()
        page.get_by_role("button", name=re.compile("monday")).click()
        page.get_by_label("Name", exact=True).fill("Monday's walk")
        page.get_by_label("What keys would do now").get_by_text("make the session").wait_for()
        page.get_by_label("Date").focus()
        page.get_by_role("button", name="Make it, then calibrate").click()
        page.get_by_role("heading", name="Cameras & calibration").wait_for()
        studio.press("Shift+Enter")
        page.locator("[data-grade=green]").wait_for()
        assert float(page.locator("[data-residual=cam1]").inner_text().split()[0]) < 0.2
        page.get_by_role("button", name="What if it is lost").first.click()
        page.get_by_text("without cam1, in the middle level").wait_for()
        page.get_by_role("button", name="Home", exact=True).click()
        page.get_by_role("button", name="Run walk01", description="Run").click()
        page.get_by_text("done", exact=True).wait_for()
        studio.open()
        assert page.get_by_text("20 frames").count() == 1 and studio.errors == []
        written, truth = folder / "results" / "walk01" / "walk01.c3d", np.load(folder / "truth.npz")
        seen = markers_of(written, truth)
        for track, name in seen.items():
            studio.press("Control+k")
            page.keyboard.type(f"{track} select")
            studio.press("Enter", "l")
            page.get_by_role("combobox").fill(name)
            before = studio.head
            studio.press("Enter").acted(before)
        Operator(studio).finish("results/walk01/walk01.c3d")
        studio.press("Escape")
        page.get_by_role("button", name="Cameras", exact=True).click()
        page.locator("[data-grade=green]").wait_for()
        assert studio.errors == []
        context.close()
    assert (folder / "session.toml").is_file() and len(set(seen.values())) >= MOST_NAMED
    assert sorted(read_c3d(written).trajectories.names) == sorted(set(seen.values()))
    assert all(track == name for track, name in markers_of(written, truth).items())


def test_balls_are_clicked_a_wrong_one_undone_and_nothing_is_lost_with_the_browser(tmp_path, chromium_running):
    folder = recorded(tmp_path / "box", motion="feeding", barrel=0.0)
    rows = list(csv.DictReader((folder / "points.csv").read_text().splitlines()))
    with (folder / "points.csv").open("w", newline="") as file:
        writer = csv.DictWriter(file, ["name", "x_mm", "y_mm", "z_mm"], extrasaction="ignore")
        writer.writeheader()
        writer.writerows(rows)
    with served(folder) as server:
        studio, context = opened(chromium_running, server)
        page = studio.page
        page.get_by_role("button", name="New session …").click()
        page.get_by_role("button", name=re.compile("box")).click()
        page.get_by_role("button", name="Make it, then calibrate").click()
        image = page.locator("canvas[data-camera=cam1]")
        image.wait_for()

        def click(camera, name, near=1.5):
            row = next(one for one in rows if one["name"] == name)
            u, v = float(row[f"{camera}_u_px"]), float(row[f"{camera}_v_px"])
            box = page.locator(f"canvas[data-camera={camera}]").bounding_box()
            scale = box["width"] / 376
            page.mouse.click(box["x"] + (u + 0.5 + near) * scale, box["y"] + (v + 0.5) * scale)

        def pointed(camera, name):
            """The same by keys alone: from spot to spot until the ball is framed."""
            row = next(one for one in rows if one["name"] == name)
            image = page.locator(f"canvas[data-camera={camera}]")
            for _ in range(20):
                before = image.get_attribute("data-spot")
                studio.press(".")
                page.locator(f"canvas[data-camera={camera}]:not([data-spot='{before}'])").wait_for()
                spot = [float(one) for one in image.get_attribute("data-spot").split()]
                if np.hypot(spot[0] - float(row[f"{camera}_u_px"]), spot[1] - float(row[f"{camera}_v_px"])) < 2:
                    return studio.press("Space")
            raise AssertionError(f"{name} of {camera} is none of the spots")

        ball = page.locator("[data-ball='cam1 CB1']")
        click("cam1", "CB2")
        page.locator("[data-ball='cam1 CB1'][data-seen=true]").wait_for()
        studio.idle().press("Backspace")
        page.locator("[data-ball='cam1 CB1'][data-seen=asked][aria-current=step]").wait_for()
        for camera in ("cam1", "cam2", "cam3"):
            for row in rows:
                page.locator(f"[data-ball='{camera} {row['name']}'][aria-current=step]").wait_for()
                studio.idle()
                if (camera, row["name"]) == ("cam2", "CB4"):
                    studio.press("b")
                    page.locator(f"[data-ball='{camera} CB4'][data-seen=false]").wait_for()
                    page.close()  # in the midst
                    studio = Studio(context, server)
                    page = studio.page
                    page.goto(server.base + studio.asked)
                    page.get_by_role("button", name=re.compile("^Cameras of")).click()
                    page.locator(f"canvas[data-camera={camera}]").wait_for()
                    continue
                (pointed if camera == "cam3" else click)(camera, row["name"])
                page.locator(f"[data-ball='{camera} {row['name']}'][data-seen=true]").wait_for()
            if page.locator(f"[data-ball='{camera} reference marker'][aria-current=step]").count():
                studio.idle().press("b")
        studio.idle()
        studio.press("Shift+Enter")
        page.locator("[data-grade]").wait_for()
        residuals = [float(one.split()[0]) for one in page.locator("[data-residual]").all_inner_texts()]
        assert max(residuals) < 0.5 and studio.errors == [], studio.errors
        context.close()
    said = list(csv.DictReader((folder / "points.csv").read_text().splitlines()))
    off = [
        np.hypot(float(a[f"{c}_u_px"]) - float(b[f"{c}_u_px"]), float(a[f"{c}_v_px"]) - float(b[f"{c}_v_px"]))
        for a, b in zip(said, rows, strict=True) for c in ("cam1", "cam2", "cam3")
    ]  # fmt: skip
    assert np.nanmax(off) < 1 and np.isnan(off).sum() == 1 and ball is not None


@pytest.fixture
def eating(tmp_path):
    """A file of an arm that feeds; a wrist marker leaps in frame 81."""
    from kinemark.data import MarkerTrajectory, Trajectories, Trial
    from kinemark.io.trial import write_trial
    from kinemark.synth.arm import arm

    subject = arm(duration_s=3.0, seed=2)
    xyz = subject.xyz + 0.2 * np.random.default_rng(3).normal(size=subject.xyz.shape)
    xyz[subject.names.index("WRU5"), 80] += (30, -40, 20)
    paths = tuple(MarkerTrajectory.measured(n, x) for n, x in zip(subject.names, xyz, strict=True))
    write_trial(Trial("eating", Trajectories(paths, 50.0)), tmp_path / "eating.c3d")
    return tmp_path / "eating.c3d"


def test_a_click_on_a_leap_leads_to_its_marker_in_its_frame(eating, chromium_running):
    with served(eating) as server:
        studio, context = opened(chromium_running, server)
        page = studio.open("angles", "eating.c3d").page
        plot = page.locator("[data-angle^='wrist']").first.locator(".u-over")
        plot.scroll_into_view_if_needed()
        box = plot.bounding_box()
        page.mouse.click(box["x"] + box["width"] * 80 / 149, box["y"] + box["height"] / 2)
        page.locator("[data-marker=WRU5][data-frame='81']").wait_for()
        studio.idle().press("Space")
        page.locator("main[data-frame='82']").wait_for()
        studio.press("Backspace")
        page.locator("main[data-frame='81']").wait_for()
        studio.press("Enter")
        page.locator("main[data-screen=tracks][data-frame='81']").wait_for()
        page.get_by_role("img", name=re.compile("of WRU5 over time")).wait_for()
        page.get_by_role("button", name="Angles").click()
        page.get_by_role("button", name=".shd .elb .wst", exact=True).click()
        page.get_by_text("Written:").wait_for()
        limb, seen = page.get_by_role("img", name="The limb in space"), set()
        for side in ("Front", "Side", "Above"):
            page.get_by_role("button", name=side, exact=True).click()
            studio.idle().page.wait_for_timeout(100)
            seen.add(limb.screenshot())
        assert len(seen) == 3, "from any side"
        assert studio.errors == []
        context.close()
    assert {path.suffix for path in eating.parent.glob("eating.*")} == {".c3d", ".shd", ".elb", ".wst"}
