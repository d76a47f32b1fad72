"""Whoever is not a page of the studio's own is refused, by every route and socket that the app has."""

import asyncio
import os
import re

import pytest

pytest.importorskip("fastapi", reason="the studio's dependencies are absent: pip install 'kinemark[studio]'")

from fastapi.routing import APIRoute, APIWebSocketRoute
from starlette.routing import BaseRoute

from kinemark.apps.studio.guard import HEADERS
from support.asgi import HOST
from support.studio import Studio, file_in

VALUES = {"trial": "0123456789abcdef", "frame": "1", "first": "1", "marker": "LKNE", "camera": "c0", "name": "x.js"}
QUERY = "?first=1&last=2&of=0&other=0&camera=c0&u=1&v=1&x=0&y=0&w=1&h=1&name=a.c3d"
ATTACKS = {
    "no secret": {"cookie": ""},
    "another's secret": {"cookie": "kinemark-8765=" + "A" * 43},
    "an empty secret": {"cookie": "kinemark-8765="},
    "a broken cookie": {"cookie": 'kinemark-8765="\\;;==,'},
    "rebound name": {"host": "evil.example:8765"},
    "another port": {"host": "127.0.0.1:80"},
    "no host": {"host": ""},
    "foreign page": {"origin": "http://evil.example"},
    "foreign page by port": {"origin": "http://127.0.0.1:9999"},
    "page without origin": {"origin": "null"},
    "another scheme": {"origin": f"https://{HOST}"},
    "script without token": {"origin": "", "x-kinemark": "1", "cookie": ""},
    "script with a wrong token": {"origin": "", "x-kinemark": "1", "cookie": "", "authorization": "Bearer x"},
}


def every_route(routes):
    """Method and address of everything that the app answers to, however it was added."""
    for route in routes:
        inner = getattr(getattr(route, "original_router", route), "routes", None)  # newer FastAPI nests them
        if inner:
            yield from every_route(inner)
        elif isinstance(route, APIRoute):
            for method in sorted(route.methods):
                yield method, re.sub(r"{(\w+)}", lambda m: VALUES.get(m[1], VALUES["trial"]), route.path)
        elif isinstance(route, APIWebSocketRoute):
            yield "WEBSOCKET", route.path
        else:
            assert isinstance(route, BaseRoute)
            raise AssertionError(f"{route} is of a kind that this test does not know: teach it, or leave it out")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    file_in(found := tmp_path_factory.mktemp("studio"))
    return found


@pytest.fixture(scope="module")
def studio(folder):
    return Studio(folder)


def files(folder):
    return {path.relative_to(folder): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def asked(studio, method, path, **headers):
    if method == "WEBSOCKET":
        return studio.page.socket(path, **headers)
    return studio.page.request(method, path + QUERY, b"{}", **headers)


def test_the_table_has_all_that_the_app_answers_to(studio):
    found = list(every_route(studio.app.routes))
    assert ("WEBSOCKET", "/api/live") in found and ("POST", f"/api/trials/{VALUES['trial']}/acts") in found
    assert len(found) >= 20


@pytest.mark.parametrize("attack", ATTACKS)
def test_every_route_and_socket_refuses(studio, folder, attack):
    before = files(folder)
    for method, path in every_route(studio.app.routes):
        answer = asked(studio, method, path, **ATTACKS[attack])
        if method == "WEBSOCKET":
            assert answer == "websocket.close", path
        else:
            assert answer.status == 403, (method, path)
            assert b"trials" not in answer.body
            assert {name.lower() for name in HEADERS} <= set(answer.headers)
    assert files(folder) == before


def test_what_could_change_anything_must_say_where_it_comes_from(studio):
    for method, path in every_route(studio.app.routes):
        answer = asked(studio, method, path, origin="")
        if method == "WEBSOCKET":
            assert answer == "websocket.close"
        else:
            assert (answer.status == 403) == (method not in ("GET", "HEAD")), (method, path)


def test_pages_of_its_own_and_scripts_with_the_secret_are_let_in(studio):
    for method, path in every_route(studio.app.routes):
        bearer = {"origin": "", "cookie": "", "x-kinemark": "1", "authorization": f"Bearer {studio.guard.secret}"}
        for headers in ({}, {"host": "localhost:8765", "origin": "http://localhost:8765"}, bearer):
            answer = asked(studio, method, path, **headers)
            assert answer == "websocket.accept" if method == "WEBSOCKET" else answer.status != 403


def test_the_first_address_counts_once_and_leaves_no_token(folder):
    studio = Studio(folder)
    page, token = studio.another_page(), studio.guard.token
    page.cookie = ""
    assert page.get(f"/api/home?token={token}").status == 403
    assert page.post(f"/?token={token}").status == 403
    assert page.get(f"/?token={token}", host="evil.example:8765").status == 403
    first = page.get(f"/?token={token}")
    assert first.status == 303 and first.headers["location"] == "/"
    assert re.search(r"HttpOnly.*SameSite=strict", first.headers["set-cookie"])
    assert page.get(f"/?token={token}").status == 403
    assert studio.guard.token != token


def test_other_kinds_of_connection_are_refused(studio):
    with pytest.raises(RuntimeError, match="refused"):
        asyncio.run(studio.guard({"type": "webtransport"}, None, None))


@pytest.mark.parametrize(
    "body",
    [
        b"", b"{", b"[]", b"null", b'{"head":1}', b"\xff\xfe", b"[" * 100_000, b'{"act":{"kind":"claim"}}', b"NaN",
        b'{"head":"x","act":{"kind":"put","marker":"A","frame":1,"xyz":[NaN,0,Infinity]},"why":""}',
        b'{"head":"x","act":{"kind":"claim","track":"A","name":"B","path":"/etc/passwd"}}',
        b'{"head":"x","act":{"kind":"trim","first":' + b"9" * 400 + b',"last":1}}',
    ],
    ids=lambda body: repr(body[:24]),
)  # fmt: skip
def test_malformed_bodies_are_refused_in_words_and_change_nothing(studio, folder, body):
    before = files(folder)
    for what in ("acts", "preview"):
        answer = studio.page.post(f"{studio.trial}/{what}", body)
        assert 400 <= answer.status < 500 and answer.json()["words"]
    assert files(folder) == before


def test_huge_bodies_are_refused_however_they_come(studio, folder, monkeypatch):
    before, part = files(folder), b" " * 200_000
    answer = studio.page.request(
        "POST", f"{studio.trial}/acts", chunks=[part] * 8, **{"content-type": "application/json"}
    )
    assert answer.status == 413
    monkeypatch.setattr("kinemark.apps.studio.guard.MOST_FILE_BYTES", 500_000)
    answer = studio.page.request("POST", "/api/files?name=a.c3d", chunks=[part] * 8)
    assert answer.status == 413 and files(folder) == before


@pytest.mark.parametrize(
    "name", ["../walk.c3d", "..\\..\\walk.c3d", "/etc/passwd", "a/../../b.c3d", "x\0.c3d", "../../..", "walk.c3d"]
)
def test_names_never_lead_anywhere(studio, folder, name):
    before = files(folder)
    for path in (
        f"/assets/{name}",
        f"/api/trials/{name}",
        f"/api/trials/{name}/report",
    ):
        assert studio.page.get(path).status in (404, 422), path
    answer = studio.page.get(f"{studio.trial}/gaps/{name}/1")
    assert answer.status in (404, 422) or answer.json() is None
    answer = studio.page.request("POST", f"/api/files?name={name}", b"not a file of trajectories")
    assert answer.status == 422 and files(folder) == before


def test_a_dropped_file_is_kept_in_a_folder_of_its_own_under_a_name_of_its_own(tmp_path):
    content = file_in(tmp_path, "given.c3d").read_bytes()
    studio = Studio(tmp_path / "given.c3d")
    kept = [studio.page.request("POST", "/api/files?name=..%2F..%2Fgiven.c3d", content).json() for _ in range(2)]
    assert kept[0]["id"] != kept[1]["id"]
    assert {path.name for path in (tmp_path / "dropped").iterdir()} == {"given.c3d", "given 2.c3d"}
    assert [studio.page.get(f"/api/trials/{one['id']}").status for one in kept] == [200, 200]


def test_names_of_markers_are_data_and_nothing_else(studio):
    answer = studio.page.get(studio.trial)
    assert "<img src=x onerror=alert(1)>" in [track["name"] for track in answer.json()["tracks"]]
    assert answer.headers["content-type"] == "application/json"
    assert answer.headers["x-content-type-options"] == "nosniff"
    assert "script-src" not in answer.headers["content-security-policy"]  # so that default-src 'self' holds
    paths = studio.page.get(f"{studio.trial}/paths").headers["x-kinemark-paths"]
    assert "\n" not in paths and paths.isascii()


@pytest.mark.skipif(os.name == "nt", reason="Windows lets administrators alone make links")
def test_links_that_lead_out_of_a_folder_are_not_there(tmp_path):
    inside, outside = tmp_path / "inside", tmp_path / "outside"
    inside.mkdir()
    outside.mkdir()
    (inside / "link.c3d").symlink_to(file_in(outside))
    (inside / "folder").symlink_to(outside)
    home = Studio(inside).page.get("/api/home").json()
    assert home["files"] == [] and home["sessions"] == []
