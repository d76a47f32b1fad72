"""Curves of a marker that has no sample any more keep their axes: nothing jumps, and undoing is drawn at once."""

from support.studio import file_in
from support.studio_page import Studio, needed, served, window


def test_axes_stay_when_a_marker_is_emptied_and_come_back_with_it(tmp_path, chromium_running):
    needed()
    file_in(tmp_path)
    with served(tmp_path) as server:
        context = window(chromium_running)
        studio = Studio(context, server).enter(server.address)
        page = studio.page
        page.get_by_role("button", name="walk.c3d").or_(page.locator("th button")).first.click()
        page.locator("main[data-screen=tracks] canvas").first.wait_for()
        studio.idle().press(".")
        page.locator(".uplot").first.wait_for()
        places = "() => [...document.querySelectorAll('.u-over')].map((one) => one.getAttribute('style'))"
        before, off = page.evaluate(places), page.locator(".u-axis.u-off").count()
        head = studio.head
        studio.press("u").acted(head)
        page.get_by_text("missing here").wait_for()
        assert (page.evaluate(places), page.locator(".u-axis.u-off").count()) == (before, off)
        head = studio.head
        studio.press("Control+z").acted(head)
        assert page.evaluate(places) == before
        context.close()
