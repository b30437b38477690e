"""A replay to keep: one HTML file that holds the scene, its motion and the viewer, and opens offline."""

import gzip
from base64 import b64encode
from pathlib import Path

from pydrake.geometry import Meshcat

from soft_gripper.files.output import atomic_file

_PAGE = """<!DOCTYPE html>
<html><head><meta charset="utf-8"><title>soft-gripper replay</title></head><body>
<noscript>The replay needs JavaScript.</noscript>
<script>
// Meshcat's own page is kept compressed inside this one, which it replaces.
(async () => {
  const packed = await fetch("data:application/gzip;base64,%s");
  const page = await new Response(packed.body.pipeThrough(new DecompressionStream("gzip"))).text();
  document.open();
  document.write(page);
  document.close();
})();
</script></body></html>
"""


def write_replay(meshcat: Meshcat, path: Path) -> None:
    """Writes what Meshcat shows and has recorded."""
    packed = gzip.compress(meshcat.StaticHtml().encode(), mtime=0)
    with atomic_file(path) as partial:
        partial.write_text(_PAGE % b64encode(packed).decode(), encoding="utf-8")
