"""The page that shows Meshcat with live plots beside it, served on a port of its own."""

import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from threading import Thread
from typing import Any
from urllib.parse import parse_qs, quote, urlsplit
from urllib.request import urlopen

from pydrake.geometry import Meshcat

from soft_gripper.diagrams.live.signal_feed import SignalFeed
from soft_gripper.errors import InputError

PORTS = range(7100, 7200)  # after those of Meshcat
_PAGE = Path(__file__).parent / "page"
_HTML = "text/html; charset=utf-8"
_FILES = {
    "/": ("index.html", _HTML),
    "/page.js": ("page.js", "text/javascript; charset=utf-8"),
    "/plot.js": ("plot.js", "text/javascript; charset=utf-8"),
    "/page.css": ("page.css", "text/css; charset=utf-8"),
}
# At the head of Meshcat's own page, so that it can be served here, where the page around it may open its controls and
# hand on keys: its socket leads to Meshcat's port, and the real-time rate is shown elsewhere.
_IN_SCENE = """<script>
window.WebSocket = class extends WebSocket { constructor() { super(`ws://${location.hostname}:%d/`); } };
</script><style>#stats-plot { visibility: hidden; }</style>"""
_TIMEOUT = 1.0  # s that a browser may take to send or to read


@contextmanager
def page_server(about: Mapping[str, Any], meshcat: Meshcat, feed: SignalFeed, host: str) -> Iterator[int]:
    """Serves the page at the first port that is free, which it gives, until the block ends; then no thread is left.

    Args:
        about: what the page is told once, as JSON.
        meshcat: is shown in it; it listens at the same address.
        feed: what it shows as it happens; it is closed at the end.
        host: address to listen at; "" is all of this machine's.

    Raises:
        InputError: if no port is free, or the address is none of this machine's.
    """
    files = {path: (kind, (_PAGE / name).read_bytes()) for path, (name, kind) in _FILES.items()}
    files["/scene"] = (_HTML, scene_page(meshcat).encode())
    files["/about.json"] = ("application/json", json.dumps(about).encode())
    server = _open(host, partial(_Handler, files, meshcat.port(), feed))
    thread = Thread(target=server.serve_forever, kwargs={"poll_interval": 0.1})
    thread.start()
    try:
        yield server.server_port
    finally:
        feed.close()
        server.shutdown()
        server.server_close()
        thread.join()


def scene_page(meshcat: Meshcat) -> str:
    """Meshcat's own page, to be served by any other server on this machine."""
    with urlopen(meshcat.web_url()) as answer:
        own: str = answer.read().decode()
    return own.replace("<head>", "<head>" + _IN_SCENE % meshcat.port(), 1)


class _Server(ThreadingHTTPServer):
    daemon_threads = False  # so that closing waits for them
    allow_reuse_address = False


def _open(host: str, handler: Any) -> ThreadingHTTPServer:
    reason = ""
    for port in PORTS:
        try:
            return _Server((host, port), handler)
        except OSError as error:
            reason = error.strerror or str(error)
    expected = f"none of the ports {PORTS[0]} to {PORTS[-1]} can be had there ({reason})"
    raise InputError("play", "host", host, expected)


class _Handler(BaseHTTPRequestHandler):
    """Files, and `/live?signal=A&signal=B`, server-sent events."""

    timeout = _TIMEOUT

    def __init__(self, files: Mapping[str, tuple[str, bytes]], meshcat: int, feed: SignalFeed, *arguments: Any):
        self._files, self._meshcat, self._feed = files, meshcat, feed
        super().__init__(*arguments)

    def do_GET(self) -> None:
        """Answers a request."""
        url = urlsplit(self.path)
        if url.path in self._files:
            kind, content = self._files[url.path]
            self._head(kind)
            self.wfile.write(content)
        elif url.path == "/live":
            self._stream(parse_qs(url.query).get("signal", []))
        else:
            self._redirect()

    def log_message(self, format: str, *arguments: Any) -> None:
        """Says nothing: the terminal is the user's."""

    def _redirect(self) -> None:
        """What the scene asks for beside itself is Meshcat's."""
        host = urlsplit(f"//{self.headers.get('Host', '')}").hostname or "localhost"
        self.send_response(302)
        self.send_header("Location", f"http://{host}:{self._meshcat}{quote(self.path)}")
        self.end_headers()

    def _head(self, kind: str) -> None:
        self.send_response(200)
        self.send_header("Content-Type", kind)
        self.send_header("Cache-Control", "no-store")
        self.end_headers()

    def _stream(self, signals: list[str]) -> None:
        if not self._feed.known.issuperset(signals):  # the page is of something that was played here before
            self.send_error(HTTPStatus.NOT_FOUND)
            return
        self._head("text/event-stream")
        try:
            with self._feed.listen(signals) as messages:
                while (message := messages.get()) is not None:
                    self.wfile.write(f"data: {message}\n\n".encode())
                self.wfile.write(b"event: end\ndata: end\n\n")
        except OSError:
            pass  # the browser is gone
