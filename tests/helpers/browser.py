"""A headless browser without a network, for pages that are to open offline, or that this machine serves."""

import io
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image
from waiting import LONG

Pixels = NDArray[np.int_]  # (height, width, 3) red, green, blue

_BROWSER = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
_DRIVER = shutil.which("chromedriver")
_OPTIONS = (
    "headless",
    "no-sandbox",
    "disable-gpu",
    "enable-unsafe-swiftshader",
    "no-first-run",
    "disable-background-networking",
    "disable-component-update",
    "disable-sync",
    "host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE localhost",
)


def open_offline(page: Path, profile: Path) -> Any:
    """Selenium's driver of a browser that shows a file; skips the test where there is none."""
    return open_url(page.as_uri(), profile)


def open_url(url: str, profile: Path, window: str = "1000,700", script: str = "") -> Any:
    """The same for an address, which may be of this machine.

    `window` is the size of the window in pixels; `script` runs before those of the page, and in all its frames.
    """
    webdriver = pytest.importorskip("selenium.webdriver", reason="selenium is not installed")
    if _BROWSER is None or _DRIVER is None:
        pytest.skip("needs chromium (or google-chrome) and chromedriver on the PATH")
    options = webdriver.ChromeOptions()
    options.binary_location = _BROWSER
    for option in (*_OPTIONS, f"user-data-dir={profile}", f"window-size={window}"):
        options.add_argument(f"--{option}")
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    driver = webdriver.Chrome(options=options, service=webdriver.ChromeService(_DRIVER))
    driver.command_executor.client_config.timeout = LONG
    driver.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", {"source": script})
    driver.get(url)
    return driver


def click(driver: Any, selector: str) -> None:
    """Clicks an element, which a CSS selector names, once it keeps its place and nothing covers it."""
    exceptions, support = (
        pytest.importorskip(f"selenium.{name}") for name in ("common.exceptions", "webdriver.support.ui")
    )
    rects: list[dict[str, float]] = []

    def clicks(driver: Any) -> bool:
        element = driver.find_element("css selector", selector)
        rects.append(element.rect)
        if rects[-2:] != [element.rect] * 2:
            return False
        element.click()
        return True

    soon = exceptions.NoSuchElementException, exceptions.ElementNotInteractableException
    passing = (*soon, exceptions.ElementClickInterceptedException, exceptions.StaleElementReferenceException)
    support.WebDriverWait(driver, LONG, 0.1, passing).until(clicks)


def screenshot(driver: Any) -> Pixels:
    """What the browser shows."""
    return np.asarray(Image.open(io.BytesIO(driver.get_screenshot_as_png())).convert("RGB")).astype(int)
