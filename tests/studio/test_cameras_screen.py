"""Cameras & calibration in the browser: targets as they are found on the images, and another way of calibration."""

import re

import pytest

from support.axe import needed_axe, violations
from support.studio_page import Studio, served, window


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
