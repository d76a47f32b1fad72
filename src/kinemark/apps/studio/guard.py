"""Who may speak to the server: only pages that it gave out itself, in the browser that was let in.

Everything is refused that does not show all of: a host name that is ours (a foreign one is DNS rebinding), an origin
that is ours where there is one (a foreign page) or where the request could change anything, and the secret, in a cookie
that other sites' requests do not carry or, from scripts, as a bearer token. The address that is opened first has a
token that works once, and leaves no trace of it in the browser's history.
"""

from __future__ import annotations

import secrets
from collections.abc import Callable, Iterable
from http.cookies import CookieError, SimpleCookie
from urllib.parse import parse_qs

from starlette.datastructures import Headers, MutableHeaders
from starlette.exceptions import HTTPException
from starlette.responses import PlainTextResponse, RedirectResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

MOST_BYTES = 1 << 20
"""Of a request in JSON; chosen: 500 edits are 100 kB."""
MOST_FILE_BYTES = 200_000_000
"""Of a file that is dropped on Home; chosen: ten minutes of a whole body with force plates are half of it."""
FILES = "/api/files"


class Limits:
    """Refuses bodies that are too large, before they are in memory."""

    def __init__(self, app: ASGIApp) -> None:
        self.app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Count what comes."""
        most = MOST_FILE_BYTES if scope.get("path") == FILES else MOST_BYTES
        came = 0

        async def counted() -> Message:
            nonlocal came
            message = await receive()
            if message["type"] == "http.request":
                came += len(message.get("body", b""))
                if came > most:
                    raise HTTPException(413, f"A request may bring {most} bytes, and this one brings more.")
            return message

        await self.app(scope, counted if scope["type"] == "http" else receive, send)


POLICY = "default-src 'self'; img-src 'self' blob:; frame-ancestors 'none'; base-uri 'none'; form-action 'none'"
HEADERS = {
    "Content-Security-Policy": POLICY,
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cache-Control": "no-store",
}
"""Of every answer that does not say otherwise."""
REFUSED = "This is the studio of somebody else, or its address was used before. Take the last one from the terminal.\n"


class Guard:
    """The middleware outside of the app; deny by default."""

    def __init__(
        self, app: ASGIApp, hosts: Iterable[str], port: int, *, used: Callable[[], None] | None = None
    ) -> None:
        """`hosts`: the names that the server may be called by. `used`: called when the first address was opened."""
        self.app = app
        self.hosts = frozenset(hosts)
        self.origins = frozenset(f"http://{host}" for host in self.hosts)
        self.cookie = f"kinemark-{port}"
        self.secret, self.token = secrets.token_urlsafe(32), secrets.token_urlsafe(32)
        self.used = used

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Let in, or refuse."""
        if scope["type"] == "lifespan":  # the server's own, before anybody asks
            await self.app(scope, receive, send)
            return
        if scope["type"] not in ("http", "websocket"):
            raise RuntimeError(f"{scope['type']!r} is refused")
        headers, web = Headers(scope=scope), scope["type"] == "http"
        ours = headers.getlist("host") in [[host] for host in self.hosts] and self._origin(scope, headers)
        if ours and web and self._enters(scope):
            enter = RedirectResponse("/", 303)
            enter.set_cookie(self.cookie, self.secret, httponly=True, samesite="strict")
            await enter(scope, receive, _with_headers(send))
        elif ours and self._knows_secret(headers):
            await self.app(scope, receive, _with_headers(send) if web else send)
        elif web:
            await PlainTextResponse(REFUSED, 403)(scope, receive, _with_headers(send))
        else:
            await send({"type": "websocket.close", "code": 1008})

    def _origin(self, scope: Scope, headers: Headers) -> bool:
        """Whether the request comes from a page of ours, or from a script that says that it is none."""
        said = headers.getlist("origin")
        if said:
            return len(said) == 1 and said[0] in self.origins
        script = headers.get("x-kinemark") == "1" and "authorization" in headers
        return script or (scope["type"] == "http" and scope["method"] in ("GET", "HEAD"))

    def _enters(self, scope: Scope) -> bool:
        """Whether this is the address that was opened first, which counts once."""
        if scope["path"] != "/" or scope["method"] != "GET":
            return False
        said = parse_qs(scope["query_string"].decode("latin-1")).get("token", [""])[0]
        if not _same(said, self.token):
            return False
        self.token = secrets.token_urlsafe(32)
        if self.used is not None:
            self.used()
        return True

    def _knows_secret(self, headers: Headers) -> bool:
        """By a cookie, or as a bearer token."""
        try:
            cookie = SimpleCookie(headers.get("cookie", "")).get(self.cookie)
        except CookieError:
            cookie = None
        bearer = headers.get("authorization", "").removeprefix("Bearer ")
        return _same(cookie.value if cookie else "", self.secret) or _same(bearer, self.secret)


def _same(said: str, wanted: str) -> bool:
    """In a time that does not tell how much of it is right."""
    return secrets.compare_digest(said.encode("utf-8", "replace"), wanted.encode())


def _with_headers(send: Send) -> Send:
    """Every answer says what browsers may do with it."""

    async def sent(message: Message) -> None:
        if message["type"] == "http.response.start":
            headers = MutableHeaders(scope=message)
            for name, value in HEADERS.items():
                headers.setdefault(name, value)
        await send(message)

    return sent
