"""Drives a headless Chromium through its DevTools pipe: real clicks, and what the page says."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import tempfile
import time
from pathlib import Path
from typing import Any

NAMES = ("chromium-headless-shell", "chromium", "chromium-browser", "google-chrome")
FLAGS = (
    *("--headless", "--no-sandbox", "--disable-dev-shm-usage", "--remote-debugging-pipe"),
    *("--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--window-size=900,600"),
)
PATIENCE_S = 60.0


def find() -> str | None:
    """The program of a Chromium, None where there is none."""
    return next((path for name in NAMES if (path := shutil.which(name))), None)


class Browser:
    """One page. Messages are JSON ended by a zero byte, in on descriptor 3, out on 4.

    Attributes:
        errors: what the page complained about.
        pages: files to open, by name.
    """

    def __init__(self, program: str) -> None:
        to_read, self.out = os.pipe()
        self.read, to_write = os.pipe()
        self.folder = tempfile.TemporaryDirectory(ignore_cleanup_errors=True)
        command = [program, *FLAGS, f"--user-data-dir={self.folder.name}", "about:blank"]
        self.process = subprocess.Popen(
            ["bash", "-c", f'exec "$@" 3<&{to_read} 4>&{to_write}', "bash", *command],
            pass_fds=(to_read, to_write),
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        os.close(to_read)
        os.close(to_write)
        self.number, self.unread, self.session = 0, b"", ""
        self.errors: list[str] = []
        self.pages: dict[str, Path] = {}
        pages = self.ask("Target.getTargets")["targetInfos"]
        target = next(page["targetId"] for page in pages if page["type"] == "page")
        attached = self.ask("Target.attachToTarget", targetId=target, flatten=True)
        self.session = attached["sessionId"]
        self.ask("Runtime.enable")
        self.ask("Log.enable")
        self.ask("Page.enable")

    def __enter__(self) -> Browser:
        return self

    def __exit__(self, *_: object) -> None:
        os.close(self.out)
        os.close(self.read)
        self.process.kill()
        self.process.wait()
        self.folder.cleanup()

    def ask(self, method: str, **values: Any) -> Any:
        """Result of a DevTools command; errors of the page that come meanwhile are kept."""
        self.number += 1
        message = {"id": self.number, "method": method, "params": values}
        if self.session:
            message["sessionId"] = self.session
        os.write(self.out, json.dumps(message).encode() + b"\0")
        while True:
            answer = self._next()
            if answer.get("id") == self.number:
                assert "error" not in answer, answer
                return answer["result"]
            if answer.get("method") in ("Runtime.exceptionThrown", "Log.entryAdded"):
                self.errors.append(json.dumps(answer["params"])[:2000])

    def _next(self) -> dict[str, Any]:
        while b"\0" not in self.unread:
            data = os.read(self.read, 1 << 16)
            assert data, "the browser is gone"
            self.unread += data
        message, _, self.unread = self.unread.partition(b"\0")
        answer: dict[str, Any] = json.loads(message)
        return answer

    def open(self, page: Path) -> None:
        """Load a page and wait until it says that it is ready."""
        self.ask("Page.navigate", url=page.resolve().as_uri())
        self.wait("document.body && document.body.dataset.ready === 'yes'")

    def value(self, expression: str) -> Any:
        """Value of an expression in the page."""
        answer = self.ask("Runtime.evaluate", expression=expression, returnByValue=True)
        assert "exceptionDetails" not in answer, answer
        return answer["result"].get("value")

    def wait(self, expression: str) -> None:
        """Wait until an expression is true."""
        begin = time.monotonic()
        while not self.value(expression):
            assert time.monotonic() - begin < PATIENCE_S, f"{expression} {self.errors}"
            time.sleep(0.02)

    def click(self, selector: str, share: float = 0.5) -> None:
        """Press the mouse on an element, at a share of its width."""
        box = self.value(
            f"(() => {{ const e = document.querySelector({json.dumps(selector)});"
            " e.scrollIntoView({block: 'nearest'}); const b = e.getBoundingClientRect();"
            " return [b.x, b.y, b.width, b.height]; })()"
        )
        place = {"x": box[0] + share * box[2], "y": box[1] + box[3] / 2}
        self.mouse("mousePressed", **place)
        self.mouse("mouseReleased", **place)

    def mouse(self, kind: str, x: float, y: float) -> None:
        """One event of the left button."""
        self.ask(
            "Input.dispatchMouseEvent",
            type=kind,
            x=x,
            y=y,
            button="left",
            buttons=0 if kind == "mouseReleased" else 1,
            clickCount=1,
        )
