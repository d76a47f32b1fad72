"""Curves of an emptied marker keep their axes, so that nothing jumps; and names are written as they are."""

from dataclasses import replace

from kinemark.data import Trial
from kinemark.io.trial import write_trial
from support.studio import file_in
from support.studio_page import Studio, needed, served, window
from support.walked import clean, without


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


def test_a_name_with_a_space_is_written_with_it_in_every_list(tmp_path, chromium_running):
    """Where a name is parted, so that its end is never cut, the space went: "r asis" was "rasis" among the gaps."""
    needed()
    trial = without(clean(), 5, 60, 66)
    paths = [replace(path, name="r asis") if k == 5 else path for k, path in enumerate(trial)]
    write_trial(Trial("walk", replace(trial, paths=tuple(paths))), tmp_path / "walk.c3d")
    with served(tmp_path) as server:
        context = window(chromium_running)
        page = Studio(context, server).enter(server.address).open("gaps", trial="walk.c3d").page
        begin = page.locator("[data-gap^='r asis'] b span").first
        begin.wait_for()
        assert begin.text_content().endswith(" ")
        assert begin.evaluate("own => getComputedStyle(own).whiteSpace") == "pre"
        context.close()
