"""Cameras & calibration in the browser: targets as they are found on the images, and another way of calibration."""

import re
import shutil

import pytest

from kinemark.engine.simulate import Scene, simulate
from support.axe import needed_axe, violations
from support.studio_page import Studio, needed, served, window

FOUND = """canvas => {
  const at = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data;
  let n = 0;
  for (let i = 0; i < at.length; i += 4) n += at[i] < 110 && at[i + 1] > 190 && at[i + 2] > 120 && at[i + 2] < 190;
  return n;
}"""
"""px of the colour in which what is found is drawn."""


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_rods_are_shown_as_found_and_another_way_is_offered(folder, chromium_running, theme):
    needed_axe()
    with served(folder) as server:
        context = window(chromium_running, bypass_csp=True)  # axe is put in by evaluation, which the policy forbids
        studio = Studio(context, server, theme=theme).enter(server.address)
        page = studio.page
        page.get_by_role("button", name=re.compile("^Cameras of")).click()
        page.locator("[data-grade]").wait_for()
        page.get_by_role("button", name="As found").click()
        page.locator("[data-found='control_frame cam1 1']").wait_for()
        assert int(page.locator("[data-points]").get_attribute("data-points")) > 10
        page.locator("[data-points] select").select_option("cam2")
        page.locator("[data-found='control_frame cam2 1']").wait_for()
        found = violations(page)
        page.get_by_role("button", name="As found").click()
        page.get_by_role("button", name="Another way …").click()
        form = page.get_by_role("form", name="Another way of calibration")
        form.get_by_text("calib/{camera}.png").wait_for()
        assert form.get_by_text("now", exact=True).count() == 1
        found += violations(page)
        form.get_by_role("button", name="Leave it as it is").click()
        form.wait_for(state="detached")
        assert found == [] and studio.errors == []
        context.close()


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_a_grid_is_shown_as_found_in_every_camera_and_image(tmp_path, chromium_running, theme):
    """All of its dots, joined by rows, over the image; of an image without the grid it is said why nothing is."""
    needed(), needed_axe()
    folder = tmp_path / "arm"
    simulate(folder, scene=Scene("feeding", seconds=0.1, size_px=(376, 292), focal_px=385.0, noise=1.0, cameras=2))
    shutil.copy(folder / "calib" / "cam2.png", sorted((folder / "grid" / "cam2").iterdir())[2])
    with served(folder) as server:
        context = window(chromium_running, bypass_csp=True)
        studio = Studio(context, server, theme=theme).enter(server.address)
        page = studio.page
        page.get_by_role("button", name=re.compile("^Cameras of")).click()
        page.get_by_role("button", name="As found").click()
        for camera, frame, n in (("cam1", 1, 130), ("cam2", 1, 130), ("cam2", 2, 130), ("cam2", 3, 0)):
            page.locator("[data-points] select").select_option(camera)
            if frame > 1:
                page.get_by_label("Frame", exact=True).fill(str(frame))
                page.keyboard.press("Enter")
            page.locator(f"[data-found='linearisation {camera} {frame}'][data-points='{n}']").wait_for()
            page.locator(f"[data-shown*='{camera}']").wait_for()
            studio.idle()
            drawn = page.get_by_role("img", name=f"Image of {camera}").evaluate(FOUND)
            assert drawn > 1000 if n else drawn == 0, (camera, frame, drawn)
        assert "10 rows × 13 columns has 130" in page.locator("[data-points]").get_by_role("status").inner_text()
        assert violations(page) == [] and studio.errors == []
        page.screenshot(path=f"/tmp/s18_grid_{theme}.png")
        context.close()
