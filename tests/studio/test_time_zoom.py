"""The lanes of a trial are zoomed by the wheel, by keys and by buttons, and go on with the frame."""

import pytest

from support.studio_page import Studio, served, window


@pytest.fixture
def tracks(folder, chromium_running):
    with served(folder) as server:
        context = window(chromium_running, bypass_csp=True)
        yield Studio(context, server).enter(server.address).open()
        context.close()


def span(page, was=None):
    """First and last frame that are shown, once they are others than before; None for all."""
    lanes = page.locator("[data-span]")
    if was is not None:
        page.locator(f"[data-span]:not([data-span='{was}'])").wait_for()
    return lanes.get_attribute("data-span")


def frames(text):
    first, last = map(int, text.split("–"))
    return first, last


def test_the_wheel_zooms_about_the_pointer_and_moves_along(tracks):
    """Lanes always showed the whole trial: a gap of one frame in a minute was one pixel."""
    page = tracks.page
    box = page.locator("[data-span]").bounding_box()
    assert span(page) == ""
    page.mouse.move(box["x"] + 0.7 * box["width"], box["y"] + 6)  # the strip above the lanes
    page.mouse.wheel(0, -500)
    near = span(page, "")
    first, last = frames(near)
    assert first > 1 and last - first < 80 and first < 0.7 * 120 < last
    assert page.locator("main[data-frame='1']").count()  # the frame stays where it was
    page.keyboard.down("Shift")
    page.mouse.wheel(0, -100)
    page.keyboard.up("Shift")
    moved = frames(span(page, near))
    assert moved[0] < first and moved[1] - moved[0] == last - first
    page.mouse.wheel(0, 3000)
    assert span(page, "–".join(map(str, moved))) == ""


def test_keys_and_buttons_zoom_and_the_frame_stays_in_sight(tracks):
    page = tracks.page
    tracks.press("Control+ArrowUp")
    half = span(page, "")
    assert frames(half)[0] == 1 and frames(half)[1] <= 61
    tracks.press("End")
    end = span(page, half)
    assert frames(end)[1] == 120
    page.get_by_role("button", name="Wider").click()
    assert span(page, end) == ""
    page.get_by_role("button", name="Closer").click()
    part = span(page, "")
    tracks.press("w")
    assert span(page, part) == ""
    assert not tracks.errors


def test_a_marker_set_is_chosen_where_names_are_given(tracks):
    """`kinemark marker-set list` and a line of session.toml were what the screen said of it."""
    page = tracks.page
    tracks.press("Shift+L")
    chooser = page.get_by_role("combobox", name="Marker set")
    page.locator("select option:checked", has_text="kiss-15 (15 of 15 here)").wait_for(state="attached")
    chooser.select_option("um2as-7")
    page.get_by_text("The marker set is um2as-7").first.wait_for()
    figure = page.get_by_role("region", name="Marker set")
    figure.get_by_text("ELB4").first.wait_for()
    assert 'marker_set = "um2as-7"' in (tracks.server.folder / "session.toml").read_text("utf-8")
