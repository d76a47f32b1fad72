"""Trials that were run, that were not, and that another copy of Kinemark ran: opened, or told in words why not."""

import re

from support.studio_page import Studio, by_another_program, served, window


def entered(chromium_running, server):
    return Studio(window(chromium_running), server).enter(server.address)


def test_a_trial_that_was_run_opens_at_once_without_a_mistake_on_any_screen(studio):
    studio.open()
    for screen in ("Detect", "Labels", "Gaps", "Angles", "Report", "History", "Digitise"):
        studio.page.get_by_role("button", name=re.compile(f"^{screen}")).click()
        studio.page.locator(f"main[data-screen={screen.lower()}]").wait_for()
        studio.idle()
    studio.page.get_by_text("Nobody digitises walk01 by hand").first.wait_for()
    assert studio.errors == []


def test_a_trial_that_another_copy_ran_says_so_and_is_run_again(folder, chromium_running):
    """Then it is as it was: the same program on the same recordings."""
    with served(by_another_program(folder)) as server:
        studio = entered(chromium_running, server)
        page = studio.page
        page.get_by_text("stale", exact=True).wait_for()
        page.get_by_role("button", name="walk01", exact=True).click()
        page.get_by_text("It was run by Kinemark 0.0.9").first.wait_for()
        page.get_by_role("button", name=re.compile("^Report")).click()
        page.get_by_role("heading", name="Report", exact=True).wait_for()  # it was "Report of"
        page.get_by_role("button", name=re.compile("^Tracks")).click()
        page.get_by_role("button", name="Run it", exact=True).click()
        page.get_by_text("Errors expected").first.wait_for()
        assert studio.errors == []
        page.context.close()


def test_a_trial_that_was_not_run_is_no_mistake_of_the_browser(folder, chromium_running):
    (folder / "results" / "walk01" / "steps.json").unlink()
    with served(folder) as server:
        studio = entered(chromium_running, server)
        page = studio.page
        page.get_by_text("not run", exact=True).wait_for()
        page.get_by_role("button", name="walk01", exact=True).click()
        page.get_by_text("walk01 was not run yet").first.wait_for()
        page.get_by_role("button", name="Run it", exact=True).wait_for()
        assert studio.errors == []
        page.context.close()
