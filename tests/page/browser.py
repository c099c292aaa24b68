"""A headless Chromium, driven over its devtools protocol through two pipes: no library, no port."""

from __future__ import annotations

import base64
import json
import os
import select
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome")
HAND_OVER = """
import os, sys
ends = [os.dup(int(end)) for end in sys.argv[1:3]]
for number, end in zip((103, 104), ends): os.dup2(end, number)
for number in (3, 4): os.dup2(100 + number, number)
os.execv(sys.argv[3], sys.argv[3:])
"""
"""Starts the browser with its pipes at the file descriptors 3 and 4, where it looks for them."""
PATIENCE = 120.0
"""[s] for an answer: a machine that does much else at the same time is slow to draw."""


def executable() -> str | None:
    """The browser of this machine: the variable CHROMIUM, or one that is on the path."""
    if os.name == "nt":
        return None  # pipes are handed over in another way there
    return next((found for name in (os.environ.get("CHROMIUM"), *NAMES)
                 if name and (found := shutil.which(name))), None)  # fmt: skip


class BrowserError(Exception):
    """The browser refused something, or a script of the page failed."""


class Browser:
    """A running browser; :meth:`open` gives a tab."""

    def __init__(self, program: str, folder: str) -> None:
        read_end, self._to = os.pipe()
        self._from, write_end = os.pipe()
        self._number, self._buffer = 0, b""
        self._events: list[dict[str, Any]] = []
        self.tabs: list[Tab] = []
        self.spare: list[tuple[str, str]] = []

        self.process = subprocess.Popen(
            [
                sys.executable, "-c", HAND_OVER, str(read_end), str(write_end), program,
                "--headless=new", "--remote-debugging-pipe", "--no-sandbox",
                "--disable-gpu", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
                # whole pipelines: parts that are linked later took a sixth more to draw a page
                "--disable-angle-features=supportsGraphicsPipelineLibrary",
                "--no-first-run", "--disable-extensions", "--disable-background-networking",
                "--disable-dev-shm-usage", "--hide-scrollbars", f"--user-data-dir={folder}",
                # one process draws all tabs: to start another one is slow
                "--disable-site-isolation-trials", "--renderer-process-limit=1",
                "about:blank",
            ],
            pass_fds=(read_end, write_end), stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        )  # fmt: skip
        os.close(read_end)
        os.close(write_end)

    def close(self) -> None:
        """End it and wait for it."""
        try:
            self.send("Browser.close")
        except (BrowserError, OSError):
            self.process.kill()
        self.process.wait(timeout=PATIENCE)
        os.close(self._to)
        os.close(self._from)

    def send(self, method: str, session: str | None = None, **params: Any) -> dict[str, Any]:
        """Ask for something and wait for the answer; events meanwhile are kept."""
        self._number += 1
        message: dict[str, Any] = {"id": self._number, "method": method, "params": params}
        if session:
            message["sessionId"] = session
        os.write(self._to, json.dumps(message).encode() + b"\0")
        until = time.monotonic() + PATIENCE
        while True:
            got = self._next(until)
            if got.get("id") == self._number:
                if "error" in got:
                    raise BrowserError(f"{method}: {got['error']['message']}")
                answer: dict[str, Any] = got["result"]
                return answer
            self._events.append(got)

    def events(self, session: str, method: str) -> list[dict[str, Any]]:
        """What was heard so far."""
        return [
            e["params"]
            for e in self._events
            if e.get("sessionId") == session and e.get("method") == method
        ]

    def _next(self, until: float) -> dict[str, Any]:
        while b"\0" not in self._buffer:
            ready, _, _ = select.select([self._from], [], [], max(0.0, until - time.monotonic()))
            if not ready:
                raise BrowserError("no answer in time")
            part = os.read(self._from, 1 << 20)
            if not part:
                raise BrowserError("the browser has ended")
            self._buffer += part
        text, self._buffer = self._buffer.split(b"\0", 1)
        message: dict[str, Any] = json.loads(text)
        return message

    def open(
        self,
        path: Path | str,
        *,
        size: tuple[int, int] = (760, 480),
        dark: bool = False,
        forced: bool = False,
        still: bool = True,
        touch: bool = False,
        fragment: str = "",
        ratio: float = 0.5,
        before: str = "",
    ) -> Tab:
        """Open a file or an address in a tab of its own and wait until it has drawn.

        Few pixels are quick. ``before`` is a script that runs before those of the page.
        """
        address = path if isinstance(path, str) else path.resolve().as_uri()
        tab = Tab(self, *(self.spare.pop() if self.spare else self._empty()))
        tab.plain = not (touch or before)
        tab.send("Page.bringToFront")
        self._events = [one for one in self._events if one.get("sessionId") != tab.session]
        self.tabs.append(tab)
        tab.send(
            "Emulation.setDeviceMetricsOverride", width=size[0], height=size[1],
            deviceScaleFactor=ratio, mobile=touch,
        )  # fmt: skip
        if touch:
            tab.send("Emulation.setTouchEmulationEnabled", enabled=True, maxTouchPoints=2)
        features = [{"name": "prefers-color-scheme", "value": "dark" if dark else "light"}]
        features.append({"name": "prefers-reduced-motion", "value": "reduce" if still else ""})
        if forced:
            features.append({"name": "forced-colors", "value": "active"})
        tab.send("Emulation.setEmulatedMedia", features=features)
        if before:
            tab.send("Page.addScriptToEvaluateOnNewDocument", source=before)
        tab.send("Page.navigate", url=address + fragment)
        tab.until("document.readyState === 'complete'")
        tab.frames(3)
        return tab

    def _empty(self) -> tuple[str, str]:
        """An empty tab: its session and its target."""
        target = self.send("Target.createTarget", url="about:blank")["targetId"]
        session = self.send("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.send(f"{domain}.enable", session)
        return session, target


class Tab:
    """One open page."""

    def __init__(self, browser: Browser, session: str, target: str) -> None:
        self.browser, self.session, self.target = browser, session, target
        self.plain = True

    def send(self, method: str, **params: Any) -> dict[str, Any]:
        """Ask this tab for something."""
        return self.browser.send(method, self.session, **params)

    def run(self, script: str) -> Any:
        """The value of a JavaScript expression; promises are waited for."""
        got = self.send(
            "Runtime.evaluate", expression=script, awaitPromise=True, returnByValue=True
        )
        if "exceptionDetails" in got:
            raise BrowserError(json.dumps(got["exceptionDetails"])[:800])
        return got["result"].get("value")

    def until(self, script: str, patience: float = PATIENCE) -> None:
        """Wait until an expression is true."""
        end = time.monotonic() + patience
        while not self.run(script):
            if time.monotonic() > end:
                raise BrowserError(f"never true: {script}")
            time.sleep(0.02)

    def frames(self, count: int = 2) -> None:
        """Wait until some pictures were drawn."""
        self.run(
            f"(async () => {{ for (let i = 0; i < {count}; i++) "
            "await new Promise(requestAnimationFrame); })()"
        )

    def text(self, selector: str) -> str:
        """What an element says."""
        return str(self.run(f"document.querySelector({json.dumps(selector)}).textContent"))

    def click(self, selector: str) -> None:
        """Press a button with the mouse, where it is."""
        self.run(f"document.querySelector({json.dumps(selector)}).click()")
        self.frames()

    def slide(self, selector: str, value: float) -> None:
        """Drag a slider to a value."""
        self.run(
            f"(() => {{ const e = document.querySelector({json.dumps(selector)});"
            f" e.value = {value};"
            " e.dispatchEvent(new Event('input', {bubbles: true}));"
            " e.dispatchEvent(new Event('change', {bubbles: true})); })()"
        )
        self.frames()

    def key(self, name: str) -> None:
        """Press a key on the picture."""
        self.run("document.getElementById('view').focus()")
        self.send("Input.dispatchKeyEvent", type="keyDown", key=name)
        self.send("Input.dispatchKeyEvent", type="keyUp", key=name)
        self.frames()

    def mouse(self, kind: str, x: float, y: float, **more: Any) -> None:
        """Move, press or release the mouse."""
        self.send("Input.dispatchMouseEvent", type=kind, x=x, y=y, **more)

    def press(self, x: float, y: float) -> None:
        """Click on the picture."""
        for kind in ("mousePressed", "mouseReleased"):
            self.mouse(kind, x, y, button="left", clickCount=1)
        self.frames()

    def touch(self, kind: str, *fingers: tuple[float, float]) -> None:
        """Fingers that begin to touch, move, or end to touch."""
        points = [{"x": x, "y": y, "id": i} for i, (x, y) in enumerate(fingers)]
        self.send("Input.dispatchTouchEvent", type=kind, touchPoints=points)

    def picture(self, selector: str = "html") -> bytes:
        """A screenshot of an element as PNG."""
        clip = self.run(
            f"(() => {{ const r = document.querySelector({json.dumps(selector)})"
            ".getBoundingClientRect();"
            " return {x: r.x, y: r.y, width: r.width, height: r.height, scale: 1}; })()"
        )
        shot = self.send("Page.captureScreenshot", format="png", clip=clip)
        return base64.b64decode(shot["data"])

    def printed(self) -> bytes:
        """What a printer would get, as PDF."""
        return base64.b64decode(self.send("Page.printToPDF", printBackground=True)["data"])

    def complaints(self) -> list[str]:
        """Errors and warnings of scripts and of the browser."""
        found = [
            json.dumps(e["args"])
            for e in self.browser.events(self.session, "Runtime.consoleAPICalled")
            if e["type"] in ("error", "warning", "assert")
        ]
        thrown = self.browser.events(self.session, "Runtime.exceptionThrown")
        found += [json.dumps(e["exceptionDetails"])[:600] for e in thrown]
        entries = [e["entry"] for e in self.browser.events(self.session, "Log.entryAdded")]
        # software drawing is slow and says so
        found += [e["text"] for e in entries if e["level"] in ("error", "warning")
                  and "GPU stall" not in e["text"]]  # fmt: skip
        return found

    def requests(self) -> list[str]:
        """Addresses that were asked for, without files and data in the page itself."""
        asked = self.browser.events(self.session, "Network.requestWillBeSent")
        addresses = [e["request"]["url"] for e in asked]
        return [url for url in addresses if not url.startswith(("file:", "data:", "blob:"))]

    def close(self) -> None:
        """Leave the page. A tab without settings of its own is used again: to start one is slow."""
        if self not in self.browser.tabs:
            return
        self.browser.tabs.remove(self)
        if self.plain:
            self.send("Page.navigate", url="about:blank")
            self.browser.spare.append((self.session, self.target))
        else:
            self.browser.send("Target.closeTarget", targetId=self.target)


@contextmanager
def running(program: str) -> Iterator[Browser]:
    """A browser that ends with the block, and leaves nothing behind."""
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        browser = Browser(program, folder)
        try:
            yield browser
        finally:
            browser.close()
