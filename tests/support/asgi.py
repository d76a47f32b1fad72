"""Speaks to an app as a browser does, without a network."""

import asyncio
import json
from typing import NamedTuple
from urllib.parse import quote

HOST = "127.0.0.1:8765"


class Answer(NamedTuple):
    status: int
    headers: dict
    body: bytes

    def json(self):
        return json.loads(self.body)


class Client:
    """Keeps the cookies that it is given; says where it comes from as a page of the server's own would."""

    def __init__(self, app, host=HOST, origin=f"http://{HOST}"):
        self.app, self.host, self.origin, self.cookie = app, host, origin, ""

    def enter(self, token):
        answer = self.get(f"/?token={token}")
        self.cookie = answer.headers.get("set-cookie", "").split(";")[0]
        return answer

    def get(self, path, **headers):
        return self.request("GET", path, **headers)

    def post(self, path, body=None, **headers):
        content = body if isinstance(body, bytes) else json.dumps(body).encode()
        return self.request("POST", path, content, **{"content-type": "application/json"} | headers)

    def scope(self, kind, path, **headers):
        known = {"host": self.host, "origin": self.origin, "cookie": self.cookie} | headers
        path, _, query = path.partition("?")
        return {
            "type": kind,
            "asgi": {"version": "3.0"},
            "http_version": "1.1",
            "scheme": "ws" if kind == "websocket" else "http",
            "path": path,
            "raw_path": quote(path).encode(),
            "query_string": query.encode(),
            "root_path": "",
            "headers": [(k.encode(), v.encode("latin-1")) for k, v in known.items() if v],
            "client": ("127.0.0.1", 50000),
            "server": ("127.0.0.1", 8765),
            "subprotocols": [],
        }

    def request(self, method, path, body=b"", *, chunks=None, **headers):
        scope = self.scope("http", path, **headers) | {"method": method}
        return asyncio.run(_request(self.app, scope, chunks if chunks is not None else [body]))

    def socket(self, path="/api/live", **headers):
        """What a socket is answered first: `websocket.accept` or `websocket.close`."""
        return asyncio.run(_first(self.app, self.scope("websocket", path, **headers)))


async def _request(app, scope, chunks):
    coming, said, done = iter(chunks), [], asyncio.Event()
    left = len(chunks)

    async def receive():
        nonlocal left
        if left == 0:
            await done.wait()
            return {"type": "http.disconnect"}
        left -= 1
        return {"type": "http.request", "body": next(coming), "more_body": left > 0}

    async def send(message):
        said.append(message)
        if message["type"] == "http.response.body" and not message.get("more_body"):
            done.set()

    await app(scope, receive, send)
    start = said[0]
    headers = {k.decode().lower(): v.decode("latin-1") for k, v in start["headers"]}
    return Answer(start["status"], headers, b"".join(m.get("body", b"") for m in said[1:]))


async def _first(app, scope):
    said = asyncio.Queue()

    async def receive():
        if said.empty():
            return {"type": "websocket.connect"}
        return {"type": "websocket.disconnect", "code": 1000}

    await app(scope, receive, said.put)
    return (await said.get())["type"]
