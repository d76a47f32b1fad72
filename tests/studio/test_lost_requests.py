"""A request that is lost on its way, or refused once: what is shown is never untrue, and comes when it can be had."""

import re

import pytest

from support.studio_page import Studio, needed, served, window


@pytest.fixture
def lab(tmp_path):
    needed()
    (tmp_path / "lab" / "monday").mkdir(parents=True)
    for camera in ("cam1", "cam2"):
        (tmp_path / "lab" / "monday" / f"walk_{camera}.mkv").write_bytes(b"")
    return tmp_path / "lab"


@pytest.fixture
def opened(lab, chromium_running):
    with served(lab) as server:
        context = window(chromium_running)
        yield Studio(context, server).enter(server.address)
        context.close()


def only_once(page, address, answer):
    """The first request to an address gets this answer instead of the server's."""
    asked = []

    def answered(route):
        asked.append(route.request.url)
        answer(route) if len(asked) == 1 else route.continue_()

    page.route(address, answered)
    return asked


def lost(route):
    route.abort("connectionreset")


def failed(route):
    route.fulfill(status=500, body="Internal Server Error")


def test_folders_whose_list_was_lost_come_without_being_asked_for(opened):
    page = opened.page
    asked = only_once(page, "**/api/recordings", lost)
    page.get_by_role("button", name="New session …").click()
    page.get_by_role("alert").get_by_text("could not be had").wait_for()
    assert not page.get_by_text("There is none below").count()
    page.get_by_role("button", name=re.compile("monday")).wait_for()
    assert len(asked) == 2


def test_folders_whose_list_failed_are_not_said_to_be_none(opened):
    page = opened.page
    only_once(page, "**/api/recordings", failed)
    page.get_by_role("button", name="New session …").click()
    again = page.get_by_role("button", name="Ask again")
    again.wait_for()
    assert not page.get_by_text("There is none below").count()
    assert "500" in opened.note()
    again.click()
    page.get_by_role("button", name=re.compile("monday")).wait_for()


def test_home_that_was_lost_comes(lab, chromium_running):
    with served(lab) as server:
        context = window(chromium_running)
        studio = Studio(context, server)
        studio.page.goto(server.address)
        only_once(studio.page, "**/api/home", lost)
        studio.page.goto(server.base + studio.asked)
        studio.page.get_by_role("alert").get_by_text("could not be had").wait_for()
        studio.page.get_by_text("There is no session here yet").wait_for()
        context.close()


def test_a_screen_whose_script_was_lost_comes(lab, chromium_running):
    with served(lab) as server:
        context = window(chromium_running)
        studio = Studio(context, server)
        asked = only_once(studio.page, "**/assets/NewSession-*.js", lost)
        studio.enter(server.address)
        studio.page.get_by_role("button", name="New session …").click()
        studio.page.get_by_role("button", name=re.compile("monday")).wait_for()
        assert len(asked) >= 2
        context.close()
