"""Detect in the browser: a dim marker that was lost is found by another threshold, which is then the session's."""

import re

import pytest

from kinemark.data import Validity
from kinemark.engine.session import Session
from support.studio_page import Studio, needed, served, window
from support.tried import FRAMES, SIZE, session_in

FRAME = 6
DIM = (180 - (FRAME - 1), 120)
"""px, where a person sees it."""
LAMP = ((186, 136), (229, 174))


WHITE = """canvas => {
  const at = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data;
  let n = 0;
  for (let i = 0; i < at.length; i += 4) n += at[i] > 150 && at[i] - at[i + 2] > 90;
  return n;
}"""
"""px of an image that are drawn as white ones are."""


@pytest.fixture
def tried(tmp_path, chromium_running):
    needed()
    folder = session_in(tmp_path / "tried", "[detect]\nthreshold = 90 # too high?\nmin_area = 6\nmax_area = 400")
    with served(folder) as server:
        context = window(chromium_running)
        yield Studio(context, server).enter(server.address), folder
        context.close()


def place(page, camera, u, v):
    """Where a pixel of an image is on the screen, once it is there; images are as large as their place."""
    page.locator(f"[data-shown*='/{camera}/']").wait_for()
    box = page.get_by_role("img", name=f"Image of {camera}").bounding_box()
    scale = min(box["width"] / SIZE[0], box["height"] / SIZE[1])
    middle = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    return middle[0] + (u + 0.5 - SIZE[0] / 2) * scale, middle[1] + (v + 0.5 - SIZE[1] / 2) * scale


def tile(page, camera, markers):
    """The camera's tile when it shows so many markers."""
    found = page.locator(f"section[aria-label='{camera}'][data-markers='{markers}']")
    found.wait_for()
    return found


def test_a_lost_dim_marker_is_found_and_the_threshold_written(tried):
    studio, folder = tried
    page, file = studio.page, folder / "session.toml"
    page.get_by_role("button", name="one", exact=True).click()
    page.get_by_role("button", name="Detect", exact=True).click()
    page.get_by_label("Frame", exact=True).fill(str(FRAME))
    page.keyboard.press("Enter")
    tile(page, "c0", 2).get_by_text("2 markers, 3 refused").wait_for()
    shown = []
    for _ in range(2):  # with white pixels, and without
        page.wait_for_timeout(200)
        shown.append(page.get_by_role("img", name="Image of c0").evaluate(WHITE))
        studio.press("p")
    assert shown[0] > shown[1] + 50
    page.mouse.click(*place(page, "c0", *DIM))
    page.get_by_text("Not white: grey level").wait_for()
    studio.press("[")
    field = page.get_by_label("Threshold", exact=True)
    assert field.input_value() == "89"
    page.get_by_role("button", name=re.compile(r"^Try threshold")).click()
    tile(page, "c0", 3)
    page.get_by_text("A marker:").wait_for()
    assert "threshold = 90 # too high?" in file.read_text("utf-8"), "nothing is written before it is applied"
    studio.press("m")
    page.mouse.move(*place(page, "c0", *LAMP[0]))
    page.mouse.down()
    page.mouse.move(*place(page, "c0", *LAMP[1]))
    page.mouse.up()
    page.get_by_text(re.compile(r"c0 4\d × 3\d px at 18\d, 13\d")).wait_for()
    tile(page, "c0", 3)
    studio.idle().press("Escape", "Enter")
    page.get_by_text("Written into session.toml").wait_for()
    text = file.read_text("utf-8")
    written = re.search(r"threshold = ([\d.]+) # too high\?", text)
    assert 12 < float(written[1]) < 60 and "# of the knee study" in text and 'file = "masks.toml"' in text
    studio.idle().press("Shift+Enter")
    page.get_by_text("The trial is being run.").wait_for()
    page.get_by_text("The trial was run: see Tracks.").wait_for()
    page.get_by_role("button", name="Tracks").click()
    page.get_by_text("Errors expected").first.wait_for()
    trial = Session.open(folder).trial("one").run(to="detect")
    assert trial.computed == (), "the page's run was of what the file says now"
    own = trial.detections.validity[trial.detections.camera == 0]
    assert (own == Validity.VALID).sum() == 3 * FRAMES and (own == Validity.MASKED).sum() == FRAMES
    assert studio.errors == [], "though the trial was not run at first"


def test_one_camera_alone_dark_markers_and_what_cannot_be(tried):
    studio, folder = tried
    page = studio.page
    page.get_by_role("button", name="one", exact=True).click()
    page.get_by_role("button", name="Detect", exact=True).click()
    before = tile(page, "c0", 2)
    page.locator("[data-found=yes]").wait_for()  # the cameras come one after the other
    lost = int(page.locator("section[aria-label='c1']").get_attribute("data-markers"))
    page.get_by_label("For which cameras").select_option("c1")
    field = page.get_by_label("Threshold, left open", exact=True)
    field.fill("40")
    tile(page, "c1", lost + 1)
    assert before.count() == 1, "the other camera is as it was"
    page.get_by_role("button", name="c1 alone").click()
    page.locator("section[aria-label='c0']").wait_for(state="detached")
    page.get_by_label("For which cameras").select_option("")
    page.get_by_label("Dark markers on bright ground").check()
    page.locator("section[aria-label='c1'][data-markers='0']").wait_for()
    page.get_by_label("Dark markers on bright ground").uncheck()
    page.get_by_role("button", name="Forget", exact=True).click()
    studio.idle()
    assert "cameras" not in (folder / "session.toml").read_text("utf-8")
