"""The page enlarged to 200 % on a laptop, a window of 683 × 384 px of its own: all that there is can be scrolled to."""

import re

import pytest

from support.studio_page import Studio, served, window

WIDTH, HEIGHT = 683, 384
PARTS = {
    "tracks": ("Three dimensions", "Curves", "Problems", "Selection"),
    "labels": ("Marker set", "Tracks and names", "View and links"),
    "gaps": ("Gaps", "Curves", "Three dimensions"),
    "history": ("Entries", "Difference of two versions"),
}
LEAST_PX = 60
"""Height of a part, of which more need not be seen at once."""


@pytest.fixture
def enlarged(folder, chromium_running):
    with served(folder) as server:
        context = window(chromium_running, WIDTH, HEIGHT, device_scale_factor=2)
        yield Studio(context, server).enter(server.address)
        context.close()


def test_every_part_of_a_screen_can_be_reached(enlarged):
    studio, page = enlarged, enlarged.page
    page.get_by_role("button", name="walk01", exact=True).click()
    page.locator("main[data-screen=tracks][data-frame]").wait_for()
    for screen, parts in PARTS.items():
        page.get_by_role("navigation", name="Steps").get_by_role("button", name=re.compile(screen, re.I)).click()
        page.locator(f"main[data-screen={screen}]").wait_for()
        studio.idle()
        for part in parts:
            region = page.locator(f"main [aria-label='{part}']").first
            region.scroll_into_view_if_needed()
            box = region.bounding_box()
            assert box["height"] >= LEAST_PX and box["x"] >= 0 and box["x"] + box["width"] <= WIDTH, (screen, part, box)
    assert studio.errors == []


def test_nothing_of_the_table_of_home_is_cut_off(enlarged):
    run = enlarged.page.get_by_role("button", name=re.compile("^Run walk01|^Run$")).last
    run.scroll_into_view_if_needed()
    box = run.bounding_box()
    assert box["x"] >= 0 and box["x"] + box["width"] <= WIDTH
