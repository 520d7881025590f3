"""A headless Chromium for tests of pages."""

from __future__ import annotations

import json
import shutil
import subprocess
import time
import urllib.error
import urllib.request
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

# Sets sliders, draws, and returns the numbers of the table by their keys.
SET = """
for (const [key, value] of Object.entries(arguments[0])) {
  const input = document.getElementById(key);
  input.value = value;
  input.dispatchEvent(new Event("input"));
}
redraw();
const cells = [...document.querySelectorAll("td")];
return Object.fromEntries(cells.map((td) => [td.parentNode.id.slice(4), td.dataset.value]));
"""


class Browser:
    """A headless Chromium behind its driver, by the WebDriver protocol."""

    def __init__(self, port: int, profile: Path) -> None:
        self.driver = subprocess.Popen(
            [str(shutil.which("chromedriver")), f"--port={port}"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )
        self.root = f"http://127.0.0.1:{port}"
        options = [
            "--headless=new",
            "--no-sandbox",
            "--disable-gpu",
            "--disable-quic",
            "--no-first-run",
            "--disable-background-networking",
            "--disable-component-update",
            "--disable-sync",
            "--window-size=1300,1000",
            f"--user-data-dir={profile}",
        ]
        chosen = {"browserName": "chrome", "goog:chromeOptions": {"args": options, "binary": shutil.which("chromium")}}
        for _ in range(100):
            try:
                made = self._asked("/session", {"capabilities": {"alwaysMatch": chosen}})
                break
            except OSError:
                time.sleep(0.1)
        self.session = f"/session/{made['sessionId']}"

    def _asked(self, path: str, body: object) -> Any:
        request = urllib.request.Request(
            self.root + path, json.dumps(body).encode(), {"Content-Type": "application/json"}, method="POST"
        )
        try:
            with urllib.request.urlopen(request, timeout=60) as answer:
                return json.load(answer)["value"]
        except urllib.error.HTTPError as error:
            raise AssertionError(json.load(error)["value"]["message"].splitlines()[0]) from None

    def open(self, page: Path) -> None:
        self._asked(f"{self.session}/url", {"url": page.as_uri()})

    def run(self, program: str, *arguments: object) -> Any:
        """What a program in the page returns."""
        return self._asked(f"{self.session}/execute/sync", {"script": program, "args": list(arguments)})

    def command(self, name: str, **parameters: object) -> Any:
        """What Chromium's own protocol answers."""
        return self._asked(f"{self.session}/goog/cdp/execute", {"cmd": name, "params": parameters})

    def drag(
        self, start: Sequence[float], by: Sequence[float], *, steps: int, time: float = 16.0, kind: str = "mouse"
    ) -> None:
        """Press the mouse or a finger at a place in the window, move it in steps of so many milliseconds, let go."""

        def move(share: float, duration: float) -> dict[str, Any]:
            x, y = (round(a + share * b) for a, b in zip(start, by, strict=True))
            return {"type": "pointerMove", "duration": int(duration), "x": x, "y": y, "origin": "viewport"}

        moves = [move((k + 1) / steps, time) for k in range(steps)]
        press, release = ({"type": kind, "button": 0} for kind in ("pointerDown", "pointerUp"))
        actions = [move(0.0, 0.0), press, *moves, release]
        one = {"type": "pointer", "id": kind, "parameters": {"pointerType": kind}, "actions": actions}
        self._asked(f"{self.session}/actions", {"actions": [one]})

    def wait(self, program: str, until: Callable[[Any], object]) -> Any:
        """What a program returns as soon as that is as it should be; after five seconds in any case."""
        for _ in range(100):
            found = self.run(program)
            if until(found):
                break
            time.sleep(0.05)
        return found

    @contextmanager
    def frame(self, number: int) -> Iterator[None]:
        """Run what follows in a frame of the page."""
        self._asked(f"{self.session}/frame", {"id": number})
        yield
        self._asked(f"{self.session}/frame/parent", {})

    def close(self) -> None:
        """End the browser by its driver, without which it would run on."""
        request = urllib.request.Request(self.root + self.session, method="DELETE")
        with urllib.request.urlopen(request, timeout=60):
            pass
        self.driver.terminate()
        self.driver.wait(20)
