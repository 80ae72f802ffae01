"""Headless Chromium, controlled by its DevTools protocol over a pair of pipes."""

from __future__ import annotations

import base64
import fcntl
import json
import os
import select
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

CHROMIUM = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
FLAGS = (
    "--headless=new", "--no-sandbox", "--disable-gpu", "--no-first-run", "--hide-scrollbars",
    "--remote-debugging-pipe", "--disable-background-networking", "--force-device-scale-factor=1",
)  # fmt: skip


class Browser:
    """One page; ``said``: errors from its console and script."""

    def __init__(self, process: subprocess.Popen[bytes], to: int, back: int) -> None:
        self._process, self._to, self._back = process, to, back
        self._waiting, self._count, self._session = b"", 0, ""
        self.said = list[str]()
        target = self._call("Target.createTarget", {"url": "about:blank"})["targetId"]
        attached = self._call("Target.attachToTarget", {"targetId": target, "flatten": True})
        self._session = attached["sessionId"]
        for domain in ("Page", "Runtime", "Log"):
            self._call(f"{domain}.enable")

    def show(self, width: int, height: int, *, dark: bool = False, touch: bool = False) -> None:
        """Set the window's size in pixels and its user's preferences."""
        size = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": touch}
        self._call("Emulation.setDeviceMetricsOverride", size)
        self._call("Emulation.setTouchEmulationEnabled", {"enabled": touch})
        scheme = {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}
        self._call("Emulation.setEmulatedMedia", {"features": [scheme]})

    def open(self, url: str, ready: str = "document.readyState === 'complete'") -> None:
        """Load a page and wait until an expression is true in it."""
        self._call("Page.navigate", {"url": url})
        self.wait(ready)

    def wait(self, ready: str, seconds: float = 60.0) -> None:
        """Wait until an expression is true."""
        end = time.monotonic() + seconds
        while not self.value(f"Boolean({ready})"):
            assert time.monotonic() < end, f"{ready}: not within {seconds} s; {self.said}"
            time.sleep(0.05)

    def value(self, expression: str) -> Any:
        """Value of an expression, awaited if it is a promise."""
        wanted = {"expression": expression, "awaitPromise": True, "returnByValue": True}
        found = self._call("Runtime.evaluate", wanted)
        assert "exceptionDetails" not in found, found["exceptionDetails"]
        return found["result"].get("value")

    def press(self, key: str, code: str = "") -> None:
        """Press and release a key."""
        named = {"key": key, "code": code or key, "text": key if len(key) == 1 else ""}
        self._call("Input.dispatchKeyEvent", {"type": "keyDown", **named})
        self._call("Input.dispatchKeyEvent", {"type": "keyUp", **named})

    def mouse(self, kind: str, x: float, y: float) -> None:
        """Press, move or release the mouse at a place in the window."""
        left = {"button": "left", "buttons": 1, "clickCount": 1}
        self._call("Input.dispatchMouseEvent", {"type": f"mouse{kind}", "x": x, "y": y, **left})

    def picture(self, path: Path, *, whole: bool = False) -> None:
        """A screenshot as PNG."""
        shot = self._call("Page.captureScreenshot", {"captureBeyondViewport": whole})
        path.write_bytes(base64.b64decode(shot["data"]))

    def _call(self, method: str, params: dict[str, Any] | None = None) -> dict[str, Any]:
        self._count += 1
        message = {"id": self._count, "method": method, "params": params or {}}
        if self._session:
            message["sessionId"] = self._session
        os.write(self._to, json.dumps(message).encode() + b"\0")
        while True:
            answer = self._read()
            if answer.get("id") == self._count:
                assert "error" not in answer, f"{method}: {answer['error']}"
                result: dict[str, Any] = answer["result"]
                return result
            self._hear(answer)

    def _read(self) -> dict[str, Any]:
        while b"\0" not in self._waiting:
            readable, _, _ = select.select([self._back], [], [], 120.0)
            part = os.read(self._back, 1 << 20) if readable else b""
            assert part, f"the browser is gone ({self._process.poll()})"
            self._waiting += part
        text, _, self._waiting = self._waiting.partition(b"\0")
        message: dict[str, Any] = json.loads(text)
        return message

    def _hear(self, event: dict[str, Any]) -> None:
        params = event.get("params", {})
        if event.get("method") == "Runtime.exceptionThrown":
            self.said.append(str(params["exceptionDetails"]))
        if event.get("method") == "Runtime.consoleAPICalled" and params["type"] == "error":
            self.said.append(str(params["args"]))
        if event.get("method") == "Log.entryAdded" and params["entry"]["level"] == "error":
            self.said.append(params["entry"]["text"])


@contextmanager
def browser(program: str, folder: Path) -> Iterator[Browser]:
    """Start a browser from the path of its program, with its files in ``folder``."""
    there, to = os.pipe()
    back, here = os.pipe()

    def place() -> None:
        os.dup2(there, 3)
        os.dup2(here, 4)

    ends = sorted((there, here))
    # High numbers, so that putting the one in its place does not close the other.
    kept = [fcntl.fcntl(end, fcntl.F_DUPFD_CLOEXEC, 40) for end in ends]
    there, here = (kept[ends.index(end)] for end in (there, here))
    process = subprocess.Popen(
        [program, *FLAGS, f"--user-data-dir={folder}"],
        pass_fds=(3, 4), preexec_fn=place, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
    )  # fmt: skip
    for end in {*ends, *kept}:
        os.close(end)
    try:
        yield Browser(process, to, back)
    finally:
        os.close(to)
        process.terminate()
        process.wait(30)
        os.close(back)
