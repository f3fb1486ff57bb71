"""A headless Chromium, spoken to by its debugging protocol: what a page shows a person, after what has happened to it."""

import base64
import contextlib
import itertools
import json
import pathlib
import subprocess
import time
import urllib.error
import urllib.request

import websocket

START_S = 60.0


class Page:
    """One page. Expressions are JavaScript's; times in seconds."""

    def __init__(self, socket):
        self._socket = socket
        self._numbers = itertools.count(1)

    def _ask(self, method: str, **parameters) -> dict:
        number = next(self._numbers)
        self._socket.send(json.dumps({"id": number, "method": method, "params": parameters}))
        while (answer := json.loads(self._socket.recv())).get("id") != number:
            pass  # events of the page, which nobody has asked for
        assert "error" not in answer, answer
        return answer["result"]

    def value(self, expression: str):
        return self._ask("Runtime.evaluate", expression=expression, returnByValue=True)["result"].get("value")

    def texts(self, selector: str) -> list[str]:
        """Of the elements that a CSS selector finds."""
        return self.value(f"Array.from(document.querySelectorAll({json.dumps(selector)}), e => e.textContent)")

    def wait_for(self, expression: str, seconds: float) -> None:
        until = time.monotonic() + seconds
        while not self.value(expression):
            assert time.monotonic() < until, f"{expression}: not within {seconds} s; the page shows {self.value('document.body.innerText')}"
            time.sleep(0.2)

    def resize(self, width_px: int, height_px: int) -> None:
        """A window is not made narrower than 500 px; a page may be."""
        self._ask("Emulation.setDeviceMetricsOverride", width=width_px, height=height_px, deviceScaleFactor=1, mobile=width_px < 500)

    def screenshot(self, file: pathlib.Path, whole: bool = True) -> None:
        """@param whole  what stands below the window, too: the page is laid out anew for it."""
        file.write_bytes(base64.b64decode(self._ask("Page.captureScreenshot", format="png", captureBeyondViewport=whole)["data"]))


def _debugger(folder: pathlib.Path, url: str) -> str:
    """The address under which the page is spoken to. Chromium writes its port, which it chooses itself, to a file."""
    until = time.monotonic() + START_S
    while time.monotonic() < until:
        with contextlib.suppress(OSError, IndexError, urllib.error.URLError):
            port = (folder / "DevToolsActivePort").read_text().splitlines()[0]
            with urllib.request.urlopen(f"http://127.0.0.1:{port}/json/list", timeout=5) as reply:
                for target in json.load(reply):
                    if target["type"] == "page" and target["url"] == url:
                        return target["webSocketDebuggerUrl"]
        time.sleep(0.2)
    raise TimeoutError(f"the browser does not show {url} within {START_S} s")


@contextlib.contextmanager
def open_page(url: str, folder: pathlib.Path, width_px: int = 1280, height_px: int = 860):
    """@param folder  of the browser's own files, which may not be there yet."""
    process = subprocess.Popen(["chromium", "--headless=new", "--no-sandbox", "--disable-gpu", "--hide-scrollbars",
                                f"--window-size={width_px},{height_px}", f"--user-data-dir={folder}", "--remote-debugging-port=0", url],
                               stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        socket = websocket.create_connection(_debugger(folder, url), timeout=60, suppress_origin=True)
        with contextlib.closing(socket):
            yield Page(socket)
    finally:
        process.terminate()
        process.wait(timeout=30)
