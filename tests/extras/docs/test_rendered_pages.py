"""The built site in a browser: nothing is cut off at the right edge, on a desk or on a telephone.

`make docs` runs this with the folder of the site.
"""

import os
from pathlib import Path

import pytest
from browser import open_offline

# Code, tables and pictures that are wider than their place, and a page that is wider than its window. What scrolls by
# itself is not: on a desk that is no excuse for code.
WIDE = """
const wide = [], isDesk = window.innerWidth >= 1280;
const scrolls = (element) => ["auto", "scroll"].includes(getComputedStyle(element).overflowX);
for (const element of document.querySelectorAll("article :is(pre, table, img, svg, math)")) {
  const column = element.closest("article").getBoundingClientRect(), box = element.getBoundingClientRect();
  const isCut = element.matches("pre") && element.scrollWidth > element.clientWidth && (isDesk || !scrolls(element));
  let parent = element.parentElement;
  while (!parent.matches("article") && !scrolls(parent)) parent = parent.parentElement;
  const isOut = parent.matches("article") && (box.right > column.right + 1 || box.left < column.left - 1);
  if (box.width && (isCut || isOut)) wide.push(element.tagName + ": " + (element.textContent || element.src).trim());
}
if (document.documentElement.scrollWidth > window.innerWidth) wide.push("the page");
return wide.map((text) => text.slice(0, 100));
"""
WIDTHS = 1280, 390  # pixels


def wide_elements(driver, page: Path, width: int) -> list[str]:
    """Names and beginnings of what does not fit a page in a window of a width."""
    size = {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": width < 800}
    driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
    driver.get(page.as_uri())
    return driver.execute_script(WIDE)


@pytest.mark.skipif("SITE" not in os.environ, reason="make docs")
@pytest.mark.parametrize("width", WIDTHS)
def test_nothing_is_cut_off(width, tmp_path):
    site = Path(os.environ["SITE"])
    pages = sorted(site.rglob("*.html"))
    assert pages
    driver = open_offline(pages[0], tmp_path)
    try:
        found = {page.relative_to(site): wide_elements(driver, page, width) for page in pages}
    finally:
        driver.quit()
    problems = [f"{page}: {element}" for page, elements in found.items() for element in elements]
    assert not problems, "\n".join(problems)
