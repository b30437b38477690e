"""A command that serves a page, as a process."""

import gc
import json
import re
import subprocess
from http.client import HTTPConnection
from typing import Any
from urllib.parse import urlsplit

import pytest
from command_line import LISTENING
from waiting import LONG
from websockets.sync.client import ClientConnection, connect

# Without a graphics card the scene takes a core, and more the larger it is.
SMALL_SCENE = """addEventListener("DOMContentLoaded", () => {
    const scene = document.getElementById("scene");
    if (scene) scene.style.cssText = "width: 32px; height: 24px; flex: none";
});"""


def see(page: ClientConnection) -> dict[str, Any]:
    """The next message of a page, confirmed as a browser does."""
    found: dict[str, Any] = json.loads(page.recv(timeout=LONG))
    page.send(json.dumps({"seen": found["number"]}))
    return found


class Served:
    """A command in a process of its own, and the page that it serves."""

    def __init__(self, *arguments: object):
        gc.collect()  # Drake's Meshcat ends the process if it is freed in another thread, such as those of websockets
        command = [*LISTENING, *map(str, arguments)]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        assert self.process.stdout is not None
        found = (re.search(r"http://localhost:\S+", line) for line in self.process.stdout)  # notes may come before
        self.url = next(filter(None, found))[0]
        self.port = urlsplit(self.url).port or 0

    def open(self) -> ClientConnection:
        """The socket of the page."""
        return connect(f"{self.url.replace('http', 'ws')}live", origin=f"http://localhost:{self.port}", proxy=None)  # type: ignore[arg-type]

    def message(self, *signals: str) -> dict[str, Any]:
        """How things are, and the values of some signals."""
        with self.open() as page:
            page.send(json.dumps({"signals": signals}))
            while True:
                found = see(page)
                if found["values"].keys() >= set(signals):
                    return found

    def value(self, name: str) -> float:
        """The first entry of a signal."""
        return float(self.message(name)["values"][name][0])

    def end(self) -> tuple[int, str]:
        """Its exit code and what it has said, once it has ended; its port is then free."""
        said, _ = self.process.communicate(timeout=LONG)
        with pytest.raises(ConnectionRefusedError):
            HTTPConnection("127.0.0.1", self.port).connect()
        return self.process.returncode, said
