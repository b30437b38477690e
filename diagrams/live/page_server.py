"""PageServer: the page that shows Meshcat with live plots beside it, on a port of its own."""

import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from threading import Thread
from typing import Any
from urllib.parse import parse_qs, urlsplit

from soft_gripper.diagrams.live.signal_feed import SignalFeed
from soft_gripper.errors import InputError

PORTS = range(7100, 7200)  # after those of Meshcat
_PAGE = Path(__file__).parent / "page"
_FILES = {
    "/": ("index.html", "text/html; charset=utf-8"),
    "/page.js": ("page.js", "text/javascript; charset=utf-8"),
    "/plot.js": ("plot.js", "text/javascript; charset=utf-8"),
    "/page.css": ("page.css", "text/css; charset=utf-8"),
}
_TIMEOUT = 1.0  # s that a browser may take to send or to read


@contextmanager
def page_server(about: Mapping[str, Any], feed: SignalFeed, host: str) -> Iterator[int]:
    """Serves the page at the first port that is free, which it gives, until the block ends; then no thread is left.

    Args:
        about: what the page is told once, as JSON.
        feed: what it shows as it happens; it is closed at the end.
        host: address to listen at; "" is all of this machine's.

    Raises:
        InputError: if no port is free, or the address is none of this machine's.
    """
    server = _open(host, partial(_Handler, json.dumps(about).encode(), feed))
    thread = Thread(target=server.serve_forever, kwargs={"poll_interval": 0.1})
    thread.start()
    try:
        yield server.server_port
    finally:
        feed.close()
        server.shutdown()
        server.server_close()
        thread.join()


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
    """Files of the page; `/about.json`; and `/live?signal=A&signal=B`, server-sent events."""

    timeout = _TIMEOUT

    def __init__(self, about: bytes, feed: SignalFeed, *arguments: Any):
        self._about, self._feed = about, feed
        super().__init__(*arguments)

    def do_GET(self) -> None:
        """Answers a request."""
        url = urlsplit(self.path)
        if url.path in _FILES:
            name, kind = _FILES[url.path]
            self._answer((_PAGE / name).read_bytes(), kind)
        elif url.path == "/about.json":
            self._answer(self._about, "application/json")
        elif url.path == "/live":
            self._stream(parse_qs(url.query).get("signal", []))
        else:
            self.send_error(404)

    def log_message(self, format: str, *arguments: Any) -> None:
        """Says nothing: the terminal is the user's."""

    def _answer(self, content: bytes, kind: str) -> None:
        self._head(kind)
        self.wfile.write(content)

    def _head(self, kind: str) -> None:
        self.send_response(200)
        self.send_header("Content-Type", kind)
        self.send_header("Cache-Control", "no-store")
        self.end_headers()

    def _stream(self, signals: list[str]) -> None:
        self._head("text/event-stream")
        try:
            with self._feed.listen(signals) as messages:
                while (message := messages.get()) is not None:
                    self.wfile.write(f"data: {message}\n\n".encode())
                self.wfile.write(b"event: end\ndata: end\n\n")
        except OSError:
            pass  # the browser is gone
