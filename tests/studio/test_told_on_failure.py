"""Where a test of the page fails, what the page showed and the server did is told: so rare failures are explained."""

import signal

import pytest

from support.studio_page import Studio, needed, served, window
from support.studio_seen import BY_SIGNAL, seen


@pytest.mark.skipif(not BY_SIGNAL, reason="stacks are asked for by a signal of POSIX")
def test_what_is_shown_and_done_goes_with_an_error(tmp_path, chromium_running):
    needed()
    with pytest.raises(ValueError, match="no such button") as failed, served(tmp_path) as server:
        context = window(chromium_running)
        studio = Studio(context, server).enter(server.address)
        studio.page.get_by_text("There is no session here yet").wait_for()
        studio.page.route("**/api/recordings", lambda route: route.abort())
        studio.page.get_by_role("button", name="New session …").click()
        studio.page.get_by_role("alert").wait_for()
        raise ValueError("no such button")
    (note,) = failed.value.__notes__
    assert "This could not be had" in note and "/api/recordings (net::ERR_FAILED)" in note
    assert "the server lives" in note and "uvicorn" in note
    assert seen() == ""
    context.close()


def test_an_ended_server_is_told(tmp_path):
    needed()
    with pytest.raises(ValueError) as failed, served(tmp_path) as server:
        server.process.kill()
        server.process.join()
        raise ValueError
    assert f"ended with exit code {-signal.SIGKILL}" in failed.value.__notes__[0]
