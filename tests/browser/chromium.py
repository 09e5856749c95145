"""A headless Chromium, driven over its DevTools protocol."""

import base64
import io
import json
import os
import shutil
import subprocess
import time
from pathlib import Path
from urllib.request import urlopen

import numpy as np
import PIL.Image
import psutil
import websocket

NAMES = ("chromium", "chromium-browser", "google-chrome")
WAIT = 60  # s, for whatever a page is asked to come to


def found():
    """Return the browser's program, or None."""
    return next(filter(None, map(shutil.which, NAMES)), None)


class Refused(Exception):
    """A command that the browser didn't carry out, as on a page that is just being left."""


class Browser:
    """One page, and what it said and asked for.

    Parameters
    ----------
    profile : pathlib.Path
        An empty folder for the browser's own files.
    """

    def __init__(self, profile):
        flags = [
            "--headless=new", "--remote-debugging-port=0", f"--user-data-dir={profile}",
            "--no-first-run", "--disable-background-networking", "--disable-component-update",
            "--disable-sync", "--window-size=1300,1000", "--use-angle=swiftshader",
            "--enable-unsafe-swiftshader", "--remote-allow-origins=*",
        ]  # fmt: skip
        if os.geteuid() == 0:
            flags.append("--no-sandbox")
        self.process = subprocess.Popen(
            [found(), *flags, "about:blank"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )
        port = wait(lambda: Path(profile, "DevToolsActivePort").read_text().split()[0])
        with urlopen(f"http://127.0.0.1:{port}/json") as answer:
            [page] = [target for target in json.load(answer) if target["type"] == "page"]
        self.socket = websocket.create_connection(page["webSocketDebuggerUrl"], timeout=WAIT)
        self.number, self.errors, self.requests = 0, [], []
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.send(f"{domain}.enable")
        self.send("Emulation.setFocusEmulationEnabled", enabled=True)

    def close(self):
        self.socket.close()
        self.process.terminate()
        self.process.wait()

    def processor_seconds(self):
        """Return the time that processors worked for the browser so far, in s."""
        own = psutil.Process(self.process.pid)
        times = [one.cpu_times() for one in (own, *own.children(recursive=True))]
        return sum(one.user + one.system for one in times)

    def send(self, method, **params):
        """Return the answer to a command; what happened meanwhile is noted."""
        self.number += 1
        self.socket.send(json.dumps({"id": self.number, "method": method, "params": params}))
        while True:
            message = json.loads(self.socket.recv())
            if message.get("id") == self.number:
                if "error" in message:
                    raise Refused(message)
                return message["result"]
            self.note(message)

    def note(self, message):
        method, params = message["method"], message["params"]
        if method == "Network.requestWillBeSent":
            self.requests.append(params["request"]["url"])
        elif method == "Runtime.exceptionThrown":
            details = params["exceptionDetails"]
            self.errors.append(details.get("exception", {}).get("description", details["text"]))
        elif method == "Runtime.consoleAPICalled" and params["type"] == "error":
            self.errors.append(" ".join(str(a.get("value", a)) for a in params["args"]))
        elif method == "Log.entryAdded" and params["entry"]["level"] == "error":
            self.errors.append(f"{params['entry']['text']} {params['entry'].get('url', '')}")

    def open(self, address):
        """Go to an address and wait until it is there."""
        self.errors.clear()
        self.requests.clear()
        self.send("Page.navigate", url=address)
        self.until(f"location.href.split('#')[0] === {json.dumps(address.split('#')[0])} "
                   "&& document.readyState === 'complete'")  # fmt: skip

    def screen(self, width, height=800, scheme="light"):
        """Have a screen of this size, of a hand-held below 500 px; `plain_screen` takes it back."""
        self.send("Emulation.setDeviceMetricsOverride", width=width, height=height,
                  deviceScaleFactor=1, mobile=width < 500)  # fmt: skip
        wanted = {"name": "prefers-color-scheme", "value": scheme}
        self.send("Emulation.setEmulatedMedia", features=[wanted])

    def plain_screen(self):
        self.send("Emulation.clearDeviceMetricsOverride")
        self.send("Emulation.setEmulatedMedia", features=[])

    @property
    def outside(self):
        """What the page asked for that is no file of the disk."""
        return [r for r in self.requests if not r.startswith(("file:", "data:", "blob:"))]

    def run(self, script):
        """Return the value of an expression, of what it promises if it does."""
        answer = self.send(
            "Runtime.evaluate", expression=script, returnByValue=True, awaitPromise=True
        )
        assert "exceptionDetails" not in answer, answer["exceptionDetails"]
        return answer["result"].get("value")

    def until(self, script, seconds=WAIT):
        """Return an expression's value as soon as it is true, its time in s with it."""
        return wait(lambda: self.run(script), seconds, script)

    def picture(self, script):
        """Return the pixels of the element that an expression gives, brought into view."""
        box = self.run(
            f"(() => {{ const e = {script}; e.scrollIntoView({{block: 'center'}});"
            "const b = e.getBoundingClientRect();"
            "return {x: b.x + scrollX, y: b.y + scrollY, width: b.width, height: b.height}; })()"
        )
        return np.asarray(PIL.Image.open(io.BytesIO(self.shot(box))).convert("RGB"))

    def shot(self, box):
        """Return what is seen in a box of the page, as PNG."""
        shot = self.send("Page.captureScreenshot", clip=box | {"scale": 1})
        return base64.b64decode(shot["data"])

    def save_in(self, folder):
        """Let what pages offer for saving be saved there."""
        self.send("Page.setDownloadBehavior", behavior="allow", downloadPath=str(folder))

    def middle(self, script):
        """Return the middle of an element in the window."""
        return self.run(
            f"(() => {{ const b = ({script}).getBoundingClientRect();"
            "return [b.x + b.width / 2, b.y + b.height / 2]; })()"
        )

    def drag(self, script, across, down):
        """Pull at the middle of an element with the mouse."""
        x, y = self.middle(script)
        self.mouse("mousePressed", x, y)
        for part in np.linspace(0, 1, 9)[1:]:
            self.mouse("mouseMoved", x + part * across, y + part * down)
        self.mouse("mouseReleased", x + across, y + down)

    def mouse(self, kind, x, y):
        self.send("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", buttons=1,
                  clickCount=1)  # fmt: skip

    def press(self, key, code):
        """Press and release a key where the focus is."""
        for kind in ("rawKeyDown", "keyUp"):
            self.send("Input.dispatchKeyEvent", type=kind, key=key, code=key,
                      windowsVirtualKeyCode=code)  # fmt: skip
            if (key, kind) == ("Enter", "rawKeyDown"):  # what activates is the letter
                self.send("Input.dispatchKeyEvent", type="char", text="\r")


def wait(question, seconds=WAIT, said=""):
    """Return the first answer that is true."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        try:
            if answer := question():
                return answer
        except (FileNotFoundError, IndexError, Refused):
            pass
        time.sleep(0.02)
    raise TimeoutError(f"not within {seconds} s: {said}")
