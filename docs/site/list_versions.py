"""Lists the versions of the site that lie beside each other: `python docs/site/list_versions.py FOLDER`.

Every version has a folder of its own, which is not built again. versions.js beside them, which every page reads
(static/version_menu.js), names all; index.html leads to the newest. So a folder that any server shows, or that is
opened from a disk, needs nothing else.
"""

import json
import sys
from pathlib import Path

from packaging.version import Version

_INDEX = '<!DOCTYPE html><title>soft-gripper</title><meta http-equiv="refresh" content="0; url={newest}/index.html">\n'


def list_versions(folder: Path) -> None:
    """Writes versions.js and index.html beside the folders of versions, newest first."""
    versions = sorted((page.parent.name for page in folder.glob("[0-9]*/index.html")), key=Version, reverse=True)
    (folder / "versions.js").write_text(f"window.versions = {json.dumps(versions)};\n", encoding="utf-8")
    (folder / "index.html").write_text(_INDEX.format(newest=versions[0]), encoding="utf-8")


if __name__ == "__main__":
    list_versions(Path(sys.argv[1]))
