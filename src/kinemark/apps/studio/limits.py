"""How much a request may bring: a middleware that counts, whatever the request says of itself."""

from __future__ import annotations

from starlette.exceptions import HTTPException
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
