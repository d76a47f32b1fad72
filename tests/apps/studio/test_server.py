"""The server as a process: killed in the midst of acts nothing that was answered is lost; and it says what it lacks."""

import asyncio
import http.client
import json
import os
import re
import socket
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

pytest.importorskip("fastapi", reason="the studio's dependencies are absent: pip install 'kinemark[studio]'")

from kinemark.apps.studio import server
from kinemark.apps.studio.schema import FILE, text
from kinemark.apps.studio.server import hosts
from kinemark.engine.editing.files import journal_at
from support.studio import file_in

WAIT_S = 60


class Served:
    """A server of its own, and a page in it; what it says goes into a file beside."""

    def __init__(self, folder, *arguments):
        command = [sys.executable, "-m", "kinemark", "studio", *map(str, arguments), "--no-browser"]
        file = folder / f"said-{len(list(folder.iterdir()))}.txt"
        with file.open("w") as said:
            self.process = subprocess.Popen(command, stderr=said, stdout=said)
        try:
            self._enter(file)
        except BaseException:
            self.kill()
            raise

    def _enter(self, file):
        began, found, answer = time.monotonic(), None, None
        while answer is None:
            assert time.monotonic() - began < WAIT_S and self.process.poll() is None, file.read_text()
            time.sleep(0.05)
            self.said = file.read_text()
            if found := re.search(r"http://(127\.0\.0\.1:\d+)(/\?token=\S+)", self.said):
                answer = self._first(*found.groups())
        self.headers = {"Origin": f"http://{self.host}", "Cookie": answer.headers["Set-Cookie"].split(";")[0]}

    def _first(self, host, path):
        """The answer to the first address; None where nobody listens yet."""
        self.host, self.connection = host, http.client.HTTPConnection(host, timeout=WAIT_S)
        try:
            self.connection.request("GET", path)
        except ConnectionError:
            self.connection.close()
            return None
        answer = self.connection.getresponse()
        answer.read()
        return answer

    def ask(self, method, path, body=None):
        headers = self.headers | ({"Content-Type": "application/json"} if body else {})
        self.connection.request(method, path, json.dumps(body) if body else None, headers)
        return json.loads(self.connection.getresponse().read())

    def kill(self):
        self.process.kill()
        self.process.wait()
        if hasattr(self, "connection"):
            self.connection.close()


@pytest.mark.skipif(os.name == "nt", reason="kill -9 is of POSIX")
def test_what_was_answered_stands_after_a_kill_in_the_midst_of_acts(tmp_path):
    file = file_in(tmp_path)
    answered = []
    for round_ in range(2):
        served = Served(tmp_path, file)
        trial = f"/api/trials/{served.ask('GET', '/api/home')['files'][0]['id']}"
        head = served.ask("GET", trial)["head"]
        threading.Timer(0.3 + 0.2 * round_, served.process.kill).start()
        try:
            for k in range(10_000):
                act = {"kind": "erase", "marker": "LKNE", "first": k % 190 + 1, "last": k % 190 + 2}
                done = served.ask("POST", f"{trial}/acts", {"head": head, "act": act, "why": str(k)})
                head = done["head"]
                answered.append(head)
        except (http.client.HTTPException, OSError, ValueError):
            pass
        served.kill()
        journal = journal_at(file).read()
        known = {line_hash for line_hash in _heads(file)}
        assert answered and set(answered) <= known
        assert len(journal.faults) <= round_ + 1  # at most a cut-off line a kill, and it is named
    assert len(journal.entries) >= len(answered)


def _heads(file):
    from kinemark.io.edits_jsonl import hash_of

    return [hash_of(line) for line in journal_at(file).path.read_bytes().splitlines()]


def test_others_are_let_in_by_their_names_alone():
    assert hosts("127.0.0.1", 80) == ["127.0.0.1:80", "localhost:80", "[::1]:80"] == hosts("localhost", 80)
    assert hosts("192.168.1.5", 80)[0] == "192.168.1.5:80"
    assert "0.0.0.0:80" not in hosts("0.0.0.0", 80) and "[::]:80" not in hosts("::", 80)


def test_whoever_lets_others_in_is_told_what_that_means(tmp_path, monkeypatch):
    said = []
    monkeypatch.setattr(server.uvicorn.Server, "run", lambda *_, **__: None)
    for host in ("0.0.0.0", "127.0.0.1"):
        server.serve((file_in(tmp_path),), host=host, browser=False, say=said.append)
    assert ["patients' data" in one for one in said] == [True, False, False]


def test_small_answers_go_at_once():
    """A browser waited 40 ms for the second part of an answer that has two."""
    found = []

    async def answered(reader, writer):
        connection = writer.get_extra_info("socket")
        found.append(connection.getsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY))
        writer.close()

    async def asked():
        async with await asyncio.start_server(answered, sock=server._listen("127.0.0.1", 0)) as there:
            reader, writer = await asyncio.open_connection(*there.sockets[0].getsockname())
            await reader.read()
            writer.close()

    asyncio.run(asked())
    assert found[0]


def test_whoever_is_told_the_address_is_heard_at_once(tmp_path, monkeypatch):
    heard = []

    def connected(words):
        port = int(re.search(r":(\d+)/", words).group(1))
        with socket.create_connection(("127.0.0.1", port), timeout=WAIT_S):
            heard.append(port)

    monkeypatch.setattr(server.uvicorn.Server, "run", lambda *_, **__: None)
    server.serve((file_in(tmp_path),), browser=False, say=connected)
    assert len(heard) == 1


LATER = """
import sys, threading
from pathlib import Path
from kinemark.apps.studio import server
from support.asgi import Client

def asked(self, sockets):
    app = self.config.app
    client = Client(app, host=(host := sorted(app.hosts)[0]), origin=f"http://{host}")
    client.enter(app.token)
    assert threading.active_count() == 1, threading.enumerate()
    client.get("/api/jobs")  # which brings what the server's own libraries need
    before = {*sys.modules}
    trial = client.get("/api/home").json()["files"][0]["id"]
    for part in ("", "/paths?view=filled", "/problems", "/gaps", "/labels", "/history"):
        assert client.get(f"/api/trials/{trial}{part}").status == 200
    client.get("/api/recordings")
    print("LATER", *sorted({*sys.modules} - before))

server.uvicorn.Server.run = asked
server.serve((Path(sys.argv[1]),), browser=False, say=print)
"""


def test_nothing_is_imported_beside_the_first_requests(tmp_path):
    """Threads that import at the same time may get half a module of each other."""
    ran = subprocess.run(
        [sys.executable, "-c", LATER, str(file_in(tmp_path))], capture_output=True, text=True, timeout=WAIT_S,
        env=os.environ | {"PYTHONPATH": str(Path(__file__).parents[2])},
    )  # fmt: skip
    assert "LATER" in ran.stdout, ran.stderr
    assert ran.stdout.split("LATER")[1].split() == []


def test_without_its_dependencies_it_says_what_to_install_and_all_else_works(tmp_path):
    block = "import sys; sys.modules['fastapi'] = None; from kinemark.__main__ import main; main()"
    for words, wanted in ((["studio", str(tmp_path)], 'pip install "kinemark[studio]"'), (["studio", "--help"], "")):
        ran = subprocess.run([sys.executable, "-c", block, *words], capture_output=True, text=True)
        assert wanted in ran.stderr and ran.returncode == (1 if wanted else 0)


def test_what_is_not_there_is_said(tmp_path):
    ran = subprocess.run(
        [sys.executable, "-m", "kinemark", "studio", str(tmp_path / "no")], capture_output=True, text=True
    )
    assert ran.returncode == 1 and "is not there" in ran.stderr and "Traceback" not in ran.stderr


def test_the_contract_with_the_page_is_that_of_the_records():
    assert FILE.read_text("utf-8") == text(), "write it anew: python -m kinemark.apps.studio.schema"
