"""The page's server lets in who has the address, from its own page, and nobody else."""

from __future__ import annotations

import asyncio
import http.client
import json
import socket
import struct
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any
from urllib.parse import urlsplit

import pytest
from websockets.asyncio.client import connect
from websockets.exceptions import ConnectionClosed, InvalidStatus

from elutria.viewing.frames import Frame
from elutria.viewing.server import PageServer
from tests.support.frames import frame

pytestmark = pytest.mark.usefixtures("page_built")


@pytest.fixture
def page_built(monkeypatch: pytest.MonkeyPatch) -> None:
    """The page's files, as if they were built."""
    files = {"index.html": b"<p>page</p>", "page.css": b"p {}", "page.js": b"0;"}
    monkeypatch.setattr("elutria.viewing.server.page_files", lambda: files)


def served(talk: Callable[[PageServer, str], Any], wishes: list[Any] | None = None) -> Any:
    """What `talk(server, address)` gives, while the server runs."""

    async def run() -> Any:
        server = PageServer((wishes if wishes is not None else []).append)
        address = await server.start()
        try:
            return await asyncio.wait_for(talk(server, address), 20)
        finally:
            await server.stop()

    return asyncio.run(run())


def get(address: str, path: str, headers: dict[str, str] | None = None) -> tuple[int, bytes]:
    """Status and body, the path sent as it is."""
    place = urlsplit(address)
    link = http.client.HTTPConnection(str(place.hostname), place.port, timeout=10)
    link.putrequest("GET", path, skip_host=headers is not None and "Host" in headers)
    for name, value in (headers or {}).items():
        link.putheader(name, value)
    link.endheaders()
    answer = link.getresponse()
    return answer.status, answer.read()


def asked(*requests: tuple[str, dict[str, str] | None]) -> list[tuple[int, bytes]]:
    async def talk(_: PageServer, address: str) -> list[tuple[int, bytes]]:
        token = urlsplit(address).path
        with ThreadPoolExecutor() as threads:
            loop = asyncio.get_running_loop()
            return [
                await loop.run_in_executor(
                    threads, get, address, path.replace("TOKEN", token), head
                )
                for path, head in requests
            ]

    return list(served(talk))


def test_the_page_is_there_for_who_has_the_address() -> None:
    assert asked(("TOKEN", None), ("TOKENindex.html", None), ("TOKENpage.js", None)) == [
        (200, b"<p>page</p>"), (200, b"<p>page</p>"), (200, b"0;"),
    ]  # fmt: skip


def test_without_the_token_there_is_nothing() -> None:
    paths = ["/", "/index.html", "/page.js", "/stream", "/wrong/page.js", "//page.js", "TOKEN"[:0]]
    for status, body in asked(*((path or "/x", None) for path in paths)):
        assert (status, body) == (403, b"the address lacks its token\n")


@pytest.mark.parametrize(
    "path",
    ["TOKEN../server.py", "TOKEN..%2fserver.py", "TOKEN/etc/passwd", "TOKEN%2e%2e/view.py",
     "TOKENstatic/page.js", "TOKEN..\\server.py", "TOKENpage.js/../../server.py", "TOKEN."],
)  # fmt: skip
def test_no_other_file_can_be_had(path: str) -> None:
    ((status, body),) = asked((path, None))
    assert status == 404
    assert body == b"not found\n"


def test_another_name_for_this_machine_is_refused() -> None:
    """A page elsewhere whose name is made to lead here (DNS rebinding)."""
    for host in ("evil.example", "127.0.0.1", "evil.example:80", ""):
        ((status, _),) = asked(("TOKEN", {"Host": host}))
        assert status == 403


def test_it_listens_on_loopback_alone() -> None:
    async def talk(server: PageServer, _: str) -> list[Any]:
        assert server._server is not None
        return [s.getsockname() for s in server._server.sockets]

    (place,) = served(talk)
    assert place[0] == "127.0.0.1"
    with pytest.raises(OSError), socket.create_connection((_own_address(), place[1]), 1):
        pass


def _own_address() -> str:
    """Another address of this machine than loopback's usual one."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect(("192.0.2.1", 9))
            return str(probe.getsockname()[0])
        except OSError:
            return "127.0.0.2"


def stream(address: str, origin: str | None = None) -> Any:
    place = urlsplit(address)
    own = f"http://{place.netloc}"
    return connect(
        f"ws://{place.netloc}{place.path}stream", origin=own if origin is None else origin
    )


def test_a_stream_begins_from_the_own_page_alone() -> None:
    async def talk(_: PageServer, address: str) -> None:
        for origin in ("http://evil.example", "null", address.replace("http", "https")):
            with pytest.raises(InvalidStatus) as refused:
                await stream(address, origin)
            assert refused.value.response.status_code == 403
        with pytest.raises(InvalidStatus):
            await connect(address.replace("http", "ws") + "stream")  # no origin at all
        async with stream(address):
            pass

    served(talk)


def test_pages_get_what_was_said_before_and_the_newest_frame() -> None:
    async def talk(server: PageServer, address: str) -> list[Any]:
        server.tell("scene", {"x": 1})
        server.tell("state", {"state": "old"})
        server.tell("state", {"state": "new"})
        server.show(Frame(frame(1, [], samples=[5] * 6)))
        server.show(Frame(frame(2, [])))
        async with stream(address) as link:
            return [await link.recv() for _ in range(3)]

    scene, state, shown = served(talk)
    assert json.loads(scene) == {"kind": "scene", "x": 1}
    assert json.loads(state)["state"] == "new"
    assert Frame(shown).time == 2
    assert Frame(shown).samples.tolist() == [5] * 6  # told with the frame before


def test_a_slow_page_is_left_frames_out_and_holds_nothing_up() -> None:
    large = bytearray(frame(0, [(k, (0.5, 0.5, 0.5), 0.001, 0.0) for k in range(20_000)]))

    def at(time: float) -> Frame:
        struct.pack_into("<d", large, 16, time)
        return Frame(bytes(large))

    async def talk(server: PageServer, address: str) -> list[float]:
        async with stream(address) as link:
            await asyncio.sleep(0.1)
            for k in range(100):  # 32 MB that nobody reads
                server.show(at(k))
                await asyncio.sleep(0)
            times = []
            while not times or times[-1] != 99:
                times.append(Frame(await link.recv()).time)
            return times

    times = served(talk)
    assert times == sorted(times)
    assert len(times) < 60


def test_wishes_reach_the_session_and_rubbish_does_not() -> None:
    wishes: list[Any] = []

    async def talk(_: PageServer, address: str) -> None:
        async with stream(address) as link:
            for text in ("{}", "[1]", "no", '{"control": {"gas": 2}}', b"\xff"):
                await link.send(text)
            await asyncio.sleep(0.2)
        async with stream(address) as link:
            await link.send("x" * 5000)
            with pytest.raises(ConnectionClosed):
                await link.recv()

    served(talk, wishes)
    assert wishes == [{}, {"control": {"gas": 2}}]


def test_a_browser_that_is_killed_leaves_no_traceback(caplog: pytest.LogCaptureFixture) -> None:
    async def talk(server: PageServer, address: str) -> None:
        origin = address.rpartition("/")[0].rpartition("/")[0]
        page = await connect(f"ws{address[4:]}stream", origin=origin)
        page.transport.abort()
        for _ in range(100):
            server.show(Frame(frame(0.0, [(1, (0.5, 0.5, 0.5), 0.001, 0.0)])))
            await asyncio.sleep(0.01)
            if not server.watched:
                break
        assert not server.watched

    served(talk)
    assert "Traceback" not in caplog.text
    assert "failed" not in caplog.text
