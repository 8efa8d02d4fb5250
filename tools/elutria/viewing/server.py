"""The page's server: on this machine's loopback only, behind a token in the address.

Files of the page come from memory by their names; nothing of a request becomes a path. A browser
that is slow gets the newest frame when it is ready for one, the others are left out.
"""

from __future__ import annotations

import asyncio
import contextlib
import hmac
import json
import secrets
from collections.abc import Callable, Iterable
from http import HTTPStatus
from importlib.resources import files
from typing import Any

from websockets.asyncio.server import Server, ServerConnection, serve
from websockets.datastructures import Headers
from websockets.exceptions import ConnectionClosed
from websockets.http11 import Request, Response

from elutria.errors import InputError
from elutria.viewing.frames import Frame

HOST = "127.0.0.1"
KINDS = {
    "index.html": "text/html; charset=utf-8",
    "page.css": "text/css; charset=utf-8",
    "page.js": "text/javascript; charset=utf-8",
}
POLICY = "default-src 'self'; img-src 'self' data:; style-src 'self' 'unsafe-inline'"
LARGEST_WISH = 4096
"""Bytes of a message from a page, at most."""

Wish = Callable[[dict[str, Any]], None]


def page_files() -> dict[str, bytes]:
    """The page as it was built. Raises InputError where it was not."""
    folder = files("elutria.viewing") / "static"
    missing = [name for name in KINDS if not (folder / name).is_file()]
    if missing:
        raise InputError(
            f"{folder / missing[0]}: was not built; allowed: after 'etc/setup/setup', or "
            "'npm ci && npm run build' in tools/page"
        )
    return {name: (folder / name).read_bytes() for name in KINDS}


class _Client:
    """A page that looks on: what it still has to get."""

    def __init__(self, connection: ServerConnection):
        self.connection = connection
        self.texts: list[str | bytes] = []
        self.frame: Frame | None = None
        self.ready = asyncio.Event()

    async def send_all(self) -> None:
        while True:
            await self.ready.wait()
            self.ready.clear()
            texts, self.texts = self.texts, []
            for text in texts:
                await self.connection.send(text)
            if self.frame is not None:
                frame, self.frame = self.frame, None
                await self.connection.send(frame.content)


class PageServer:
    """Serves the page to any number of browsers. `on_wish` gets what a page asks for."""

    def __init__(self, on_wish: Wish):
        self.token = secrets.token_urlsafe(24)
        self._files = page_files()
        self._on_wish = on_wish
        self._clients: set[_Client] = set()
        self._kept: dict[str, str | bytes] = {}
        self._frame: Frame | None = None
        self._server: Server | None = None
        self._origins: list[str] = []

    @property
    def watched(self) -> bool:
        """Whether any page looks on."""
        return bool(self._clients)

    async def start(self, port: int = 0) -> str:
        """Listen; gives the address of the page."""
        self._server = await serve(
            self._follow, HOST, port, process_request=self._answer,
            compression=None, max_size=LARGEST_WISH, server_header=None,
        )  # fmt: skip
        port = self._server.sockets[0].getsockname()[1]
        self._origins = [f"http://{host}:{port}" for host in (HOST, "localhost")]
        return f"http://{HOST}:{port}/{self.token}/"

    async def stop(self) -> None:
        """Close all connections."""
        if self._server:
            self._server.close()
            await self._server.wait_closed()

    def show(self, frame: Frame) -> None:
        """The newest frame, for all pages."""
        if not len(frame.samples) and self._frame is not None:
            self._frame = frame.with_samples(self._frame.samples)
        else:
            self._frame = frame
        for client in self._clients:
            # the gas of a frame that this page did not get goes with the next
            skipped = client.frame is not None and len(client.frame.samples) > 0
            client.frame = self._frame if skipped else frame
            client.ready.set()

    def tell(self, kind: str, message: dict[str, Any] | bytes) -> None:
        """A message for all pages, and for those that come later."""
        text = message if isinstance(message, bytes) else json.dumps({"kind": kind, **message})
        self._kept.pop(kind, None)
        self._kept[kind] = text
        for client in self._clients:
            client.texts.append(text)
            client.ready.set()

    def forget(self, kinds: Iterable[str]) -> None:
        """Pages that come later are not told of these any more, and no frame is left."""
        for kind in kinds:
            self._kept.pop(kind, None)
        self._frame = None
        for client in self._clients:
            client.frame = None

    async def _follow(self, connection: ServerConnection) -> None:
        client = _Client(connection)
        client.texts = list(self._kept.values())
        client.frame = self._frame
        client.ready.set()
        self._clients.add(client)
        sender = asyncio.create_task(client.send_all())
        try:
            with contextlib.suppress(ConnectionClosed):  # a browser that was killed
                async for message in connection:
                    self._listen(message)
        finally:
            self._clients.discard(client)
            sender.cancel()
            with contextlib.suppress(asyncio.CancelledError, ConnectionClosed):
                await sender

    def _listen(self, message: str | bytes) -> None:
        with contextlib.suppress(ValueError, RecursionError):
            wish = json.loads(message)
            if isinstance(wish, dict):
                self._on_wish(wish)

    def _answer(self, connection: ServerConnection, request: Request) -> Response | None:
        """None where a stream may begin, else what is sent instead."""
        hosts = [origin.removeprefix("http://") for origin in self._origins]
        if request.headers.get_all("Host") not in [[host] for host in hosts]:
            return connection.respond(HTTPStatus.FORBIDDEN, "this name is not served\n")
        path = request.path.partition("?")[0]
        token, _, name = path.removeprefix("/").partition("/")
        if not hmac.compare_digest(token.encode(), self.token.encode()):
            return connection.respond(HTTPStatus.FORBIDDEN, "the address lacks its token\n")
        if name == "stream":
            if request.headers.get_all("Origin") not in [[origin] for origin in self._origins]:
                return connection.respond(HTTPStatus.FORBIDDEN, "asked from another page\n")
            return None
        content = self._files.get(name or "index.html")
        if content is None:
            return connection.respond(HTTPStatus.NOT_FOUND, "not found\n")
        headers = Headers()
        headers["Content-Type"] = KINDS[name or "index.html"]
        headers["Content-Length"] = str(len(content))
        headers["Content-Security-Policy"] = POLICY
        headers["Cache-Control"] = "no-store"
        headers["Referrer-Policy"] = "no-referrer"
        headers["X-Content-Type-Options"] = "nosniff"
        headers["Connection"] = "close"
        return Response(HTTPStatus.OK, "OK", headers, content)
