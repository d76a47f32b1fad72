"""A session and a browser for the tests of the studio's page, made once for each process."""

import pytest

from support.effort import EFFORT
from support.studio_page import Studio, browser, copied, needed, served, walked, window
from support.studio_seen import seen


@pytest.fixture(autouse=True)
def effort(record_property):
    """What the flow of a test costs a person is told at the end of the run."""
    EFFORT.begin()
    yield
    if EFFORT.keys + EFFORT.clicks:
        record_property("effort", EFFORT.said())


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item, call):
    """Servers of fixtures are there still when a test has failed."""
    report = yield
    if report.failed and call.when != "teardown" and (words := seen()):
        report.sections.append(("the studio", words))
    return report


def pytest_terminal_summary(terminalreporter):
    told = {  # by reports of the end of tests, which alone have what was recorded then
        report.nodeid: value
        for report in terminalreporter.getreports("")
        for name, value in report.user_properties
        if name == "effort"
    }
    if told:
        terminalreporter.section("what the flows cost a person, by the keystroke-level model")
    for name, value in told.items():
        terminalreporter.write_line(f"{value}  {name}")


@pytest.fixture(scope="session")
def walk(tmp_path_factory):
    needed()
    base = tmp_path_factory.getbasetemp()
    return walked(base.parent if base.name.startswith("popen") else base)


@pytest.fixture(scope="session")
def chromium_running():
    needed()
    with browser() as running:
        yield running


@pytest.fixture
def folder(walk, tmp_path):
    return copied(walk, tmp_path / "session")


@pytest.fixture
def studio(folder, chromium_running):
    """The studio on a session without faults, in a window of its own."""
    with served(folder) as server:
        context = window(chromium_running)
        yield Studio(context, server).enter(server.address)
        context.close()


@pytest.fixture
def faulty_studio(folder, chromium_running):
    """The same with a tracker that errs."""
    with served(folder, "--faults") as server:
        context = window(chromium_running)
        yield Studio(context, server).enter(server.address)
        context.close()
