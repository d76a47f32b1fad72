"""The server of the studio: a port of its own on this machine, and the address that opens it once."""

from __future__ import annotations

import importlib.readers
import ipaddress
import socket
import sys
import threading
import webbrowser
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import scipy.ndimage
import scipy.spatial
import uvicorn

from ...data import KinemarkError
from .app import studio_app
from .desk import Desk
from .guard import Guard
from .home import user
from .shelf import Shelf

LOOPBACK = "127.0.0.1"
SWITCH_S = 0.0005
"""s after which a thread that computes, as one that looks for problems does, lets others have the interpreter; chosen:
an act takes it a few times, and waits Python's 5 ms each time otherwise (see benchmarks/studio_browser.py)."""
NEEDED = (scipy.ndimage, scipy.spatial, importlib.readers)
"""Modules that are read when they are first used, here by finding computed points and problems and by marker sets; they
are read before anybody asks. Nothing is imported beside requests: threads that import at the same time wait for each
other's modules, and Python gets out of that by handing one of them half a module."""
WARNING = (
    "warning: --host {host} lets other machines of the network reach this server, and what goes over the network is "
    "not encrypted. Whoever gets the address below can see and change the patients' data in it."
)


def serve(
    paths: tuple[Path, ...], *, host: str = LOOPBACK, port: int = 0, browser: bool = True, say: Callable[[str], None]
) -> None:
    """Serve until Ctrl-C.

    Args:
        paths: folders of sessions, sessions, and files of trajectories.
        host: the address that is listened on. port: 0 takes a free one.
        browser: whether to open one. say: gets what is to be told to whoever started it.

    Raises:
        KinemarkError: a path is not there, or the port cannot be had.
    """
    desk = Desk(Shelf.of(paths), user())
    listening = _listen(host, port)
    port = listening.getsockname()[1]
    names = hosts(host, port)

    def tell() -> None:
        say(f"studio: http://{names[0]}/?token={guard.token}  (works once)")

    app = studio_app(desk)
    guard = Guard(app, names, port, used=tell)
    if not is_loopback(host):
        say(WARNING.format(host=host))
    tell()
    if browser:
        threading.Timer(0.5, webbrowser.open, [f"http://{names[0]}/?token={guard.token}"]).start()
    config = uvicorn.Config(guard, log_level="warning", lifespan="off", server_header=False, ws_max_size=1 << 16)
    sys.setswitchinterval(SWITCH_S)
    with listening, suppress(KeyboardInterrupt):  # which is how it is ended
        try:
            uvicorn.Server(config).run(sockets=[listening])
        finally:
            app.state.live.close()


def hosts(host: str, port: int) -> list[str]:
    """What browsers may call the server; the first is what it is opened by."""
    own = [f"{LOOPBACK}:{port}", f"localhost:{port}", f"[::1]:{port}"]
    if is_loopback(host):
        return own
    there = [host] if not ipaddress_any(host) else [socket.gethostname(), *_addresses()]
    return [*(f"[{one}]:{port}" if ":" in one else f"{one}:{port}" for one in there), *own]


def is_loopback(host: str) -> bool:
    """Whether nobody else can reach it."""
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"


def ipaddress_any(host: str) -> bool:
    """Whether it means all addresses of this machine."""
    try:
        return ipaddress.ip_address(host).is_unspecified
    except ValueError:
        return False


def _addresses() -> list[str]:
    """Of this machine, by its name."""
    try:
        return sorted({str(one[4][0]) for one in socket.getaddrinfo(socket.gethostname(), None)})
    except OSError:
        return []


def _listen(host: str, port: int) -> socket.socket:
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    # By this protocol's name asyncio lets small answers go at once; else their second part waits 40 ms for the first.
    found = socket.socket(family, socket.SOCK_STREAM, socket.IPPROTO_TCP)
    found.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        found.bind((host, port))
        found.listen()  # so that whoever is told the address is heard, a moment before they are answered
    except OSError as error:
        found.close()
        raise KinemarkError(
            f"{host}:{port} cannot be listened on: {error.strerror}. Give another --port, or none for a free one."
        ) from error
    return found
