"""Assembles the sources from which Sphinx builds the site: `python docs/site/stage.py FOLDER`, which is emptied before.

Pages and notebooks come from the repository, with links that hold on the site; the rest is made from the code.

Pages live in docs/ and read well on GitHub, so their links are those of the repository. The copy that Sphinx builds
has links of the site, and with it what is made from the code: API, ports (read from the systems), schema, block
diagrams. A new page is named in a table of contents: that of docs/site/index.md, or of the page of a group, such as
docs/site/howto.md, which folds in the sidebar. API pages are in no table of contents, since every page would
carry all of them.
"""

import re
import shutil
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path

from api_pages import api_pages
from block_diagrams import save_diagrams
from links import PICTURES, ROOT, linked_path, links, on_site, site_path
from overview import blocks, namespaces
from port_tables import blocks_page, signals_page
from scenario_pages import scenario_pages
from schema_page import schema_page

_LANGUAGES = {".py": "python", ".yaml": "yaml", ".urdf": "xml"}
_STATIC = "docs/site/static/"  # Sphinx copies it
_SHOWN = re.compile(r"\]\(\.\./files/(.+?)\.md\)")  # links of pages that are made from the code


def repository_pages() -> dict[str, str]:
    """The pages that the repository has, Markdown or notebooks, by their paths."""
    studies = [path for path in _files("studies", "README.md") if path != "studies/README.md"]
    paths = [*_files("docs", ".md"), *_files("notebooks", ".ipynb"), *studies, "CHANGELOG.md", "CONTRIBUTING.md"]
    return {path: (ROOT / path).read_text(encoding="utf-8") for path in paths}


def made_pages() -> Iterator[tuple[str, str]]:
    """The pages that are made from the code, and the parts of reference.md, by where they go."""
    yield "reference/namespaces.txt", namespaces()
    yield "reference/block_list.txt", blocks()
    yield "reference/scenario.md", schema_page()
    yield "reference/blocks.md", blocks_page()
    yield "reference/signals.md", signals_page()
    yield from scenario_pages()
    yield from api_pages()


def shown_files(pages: Mapping[str, str], made: Mapping[str, str]) -> set[str]:
    """Files and folders of the repository that pages link to and that are not pages."""
    linked = {linked_path(path, target) for path, text in pages.items() for target in links(path, text)}
    listed = {found for text in made.values() for found in _SHOWN.findall(text)}
    shown = {path for path in linked | listed if path is not None and site_path(path).startswith("files/")}
    return shown | {path for folder in shown if (ROOT / folder).is_dir() for path in _inside(folder)}


def stage(folder: Path) -> None:
    """Writes all pages and pictures into an empty folder."""
    shutil.rmtree(folder, ignore_errors=True)
    pages, made = repository_pages(), dict(made_pages())
    for path, text in pages.items():
        _write(folder / site_path(path), on_site(path, text))
    for path, text in made.items():
        _write(folder / path, text)
    for path in shown_files(pages, made):
        _write(folder / site_path(path), _file_page(path))
    for path in (path for ending in PICTURES for path in _files("docs", ending) if not path.startswith(_STATIC)):
        shutil.copy(ROOT / path, folder / site_path(path))
    (folder / "diagrams").mkdir()
    save_diagrams(folder / "diagrams")


def _file_page(path: str) -> str:
    """A file, or what is in a folder."""
    heading = f"---\norphan: true\n---\n\n# {path}\n\n"
    if (ROOT / path).is_dir():
        return heading + "".join(
            f"- [{Path(inner).name}]({Path(path).name}/{Path(inner).name}.md)\n" for inner in _inside(path)
        )
    text, fence = (ROOT / path).read_text(encoding="utf-8").rstrip(), "`" * 10
    code = f"{fence}{_LANGUAGES.get(Path(path).suffix, 'text')}\n{text}\n{fence}"
    return f"{heading}::::::{{container}} source\n\n{code}\n::::::\n"


def _inside(folder: str) -> list[str]:
    return [path for path in _files(folder) if Path(path).parent == Path(folder)]


def _files(folder: str, ending: str = "") -> list[str]:
    """Files below a folder of the repository, except hidden ones."""
    found = (path for path in (ROOT / folder).rglob(f"*{ending}") if path.is_file())
    paths = sorted(path.relative_to(ROOT) for path in found)
    return [path.as_posix() for path in paths if not any(part.startswith((".", "__")) for part in path.parts)]


def _write(path: Path, text: str) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    stage(Path(sys.argv[1]))
