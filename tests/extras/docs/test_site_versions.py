"""The versions of the site beside each other, in folders that are not built again."""

import json

from list_versions import list_versions


def test_versions_are_listed_the_newest_first_and_the_index_leads_to_it(tmp_path):
    for version in ("0.9", "0.10", "0.2"):
        (tmp_path / version).mkdir()
        (tmp_path / version / "index.html").write_text("a page")
    (tmp_path / "theory").mkdir()
    (tmp_path / "theory" / "index.html").write_text("of a site without versions")
    list_versions(tmp_path)
    listed = (tmp_path / "versions.js").read_text().removeprefix("window.versions = ").removesuffix(";\n")
    assert json.loads(listed) == ["0.10", "0.9", "0.2"]
    assert 'url=0.10/index.html"' in (tmp_path / "index.html").read_text()
