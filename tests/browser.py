"""A real browser for tests: headless Chromium, driven through chromedriver's own HTTP interface (W3C WebDriver)."""

from __future__ import annotations

import base64
import json
import re
import shutil
import subprocess
import time
import urllib.error
import urllib.request
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

FLAGS = (
    "--headless=new",
    "--no-sandbox",  # as root, which CI is, Chromium has none
    "--disable-dev-shm-usage",
    "--use-gl=angle",
    "--use-angle=swiftshader",  # WebGL on the processor
    "--enable-unsafe-swiftshader",
    "--hide-scrollbars",
    "--window-size=1280,900",
)
PATIENCE_S = 120.0  # software WebGL on a busy machine
_ELEMENT = "element-6066-11e4-a52e-4f735466cecf"  # what the standard calls a reference to an element


def find_browser() -> tuple[str, str] | None:
    """Chromium (or Chrome) and its driver, None where one of them is not installed."""
    browser = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
    driver = shutil.which("chromedriver")
    return (browser, driver) if browser and driver else None


class Page:
    """A session of the browser, with one page."""

    def __init__(self, session: str) -> None:
        self._session = session

    def open(self, address: str) -> None:
        _call("POST", f"{self._session}/url", {"url": address})

    def run(self, script: str, *arguments: Any) -> Any:
        """What the JavaScript function body returns."""
        return _call("POST", f"{self._session}/execute/sync", {"script": script, "args": list(arguments)})

    def wait_for(self, condition: str) -> None:
        """Until the JavaScript expression is true; an AssertionError after two minutes."""
        deadline = time.monotonic() + PATIENCE_S
        while not self.run(f"return !!({condition})"):
            assert time.monotonic() < deadline, f"{condition} has not come true; console: {self.console()}"
            time.sleep(0.2)

    def picture_of(self, selector: str) -> bytes:
        """PNG of the element as it is on the screen."""
        found = _call("POST", f"{self._session}/element", {"using": "css selector", "value": selector})
        return base64.b64decode(_call("GET", f"{self._session}/element/{found[_ELEMENT]}/screenshot"))

    def picture(self) -> bytes:
        """PNG of the window."""
        return base64.b64decode(_call("GET", f"{self._session}/screenshot"))

    def resize(self, width: int, height: int) -> None:
        _call("POST", f"{self._session}/window/rect", {"width": width, "height": height})

    def console(self) -> list[dict[str, Any]]:
        """What has been written to the console since the last call: dictionaries with `level` and `message`."""
        entries = _call("POST", f"{self._session}/se/log", {"type": "browser"})
        assert isinstance(entries, list)
        return entries

    def errors(self) -> list[str]:
        """Errors among them, refused and failed requests included."""
        return [entry["message"] for entry in self.console() if entry["level"] == "SEVERE"]

    def requests(self) -> list[str]:
        """Addresses that the page has asked for, other than those that hold their own content."""
        messages = _call("POST", f"{self._session}/se/log", {"type": "performance"})
        events = [json.loads(entry["message"])["message"] for entry in messages]
        sent = [event["params"] for event in events if event["method"] == "Network.requestWillBeSent"]
        addresses = [request["request"]["url"] for request in sent]
        return [address for address in addresses if not address.startswith(("data:", "blob:"))]


@contextmanager
def open_browser(folder: Path, *flags: str) -> Iterator[Page]:
    """A browser with a profile of its own in `folder`; find_browser() must have found one."""
    found = find_browser()
    assert found is not None
    driver = subprocess.Popen(
        [found[1], "--port=0"], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    )
    try:
        root = f"http://127.0.0.1:{_port(driver)}"
        options = {"binary": found[0], "args": [*FLAGS, f"--user-data-dir={folder / 'profile'}", *flags]}
        wanted = {
            "browserName": "chrome",
            "goog:chromeOptions": options,
            "goog:loggingPrefs": {"browser": "ALL", "performance": "ALL"},
        }
        session = _call("POST", f"{root}/session", {"capabilities": {"alwaysMatch": wanted}})
        address = f"{root}/session/{session['sessionId']}"
        try:
            yield Page(address)
        finally:
            _call("DELETE", address)
    finally:
        driver.terminate()
        driver.communicate(timeout=PATIENCE_S)


def _port(driver: subprocess.Popen[str]) -> int:
    assert driver.stdout is not None
    for line in driver.stdout:
        if found := re.search(r"started successfully on port (\d+)", line):
            return int(found[1])
    raise AssertionError("chromedriver did not start")


def _call(method: str, address: str, body: dict[str, Any] | None = None) -> Any:
    data = None if body is None else json.dumps(body).encode()
    request = urllib.request.Request(address, data, {"Content-Type": "application/json"}, method=method)
    # a proxy is for the network, not for the driver next door
    opener: Callable[..., Any] = urllib.request.build_opener(urllib.request.ProxyHandler({})).open
    try:
        with opener(request, timeout=PATIENCE_S) as answer:
            return json.load(answer)["value"]
    except urllib.error.HTTPError as error:
        raise AssertionError(f"{method} {address}: {json.load(error)['value']['message']}") from error
