"""A headless Firefox, driven over WebDriver BiDi."""

import base64
import json
import os
import shutil
import subprocess
from pathlib import Path

import websocket
from chromium import WAIT, Browser, wait

NAMES = ("firefox-esr", "firefox")


def found():
    """Return the browser's program, or None."""
    return next(filter(None, map(shutil.which, NAMES)), None)


class Firefox(Browser):
    """One page, and what it said and asked for; of files Firefox tells nothing.

    Parameters
    ----------
    profile : pathlib.Path
        An empty folder for the browser's own files.
    """

    def __init__(self, profile):
        flags = ["--headless", "--remote-debugging-port=0", "--no-remote", "--profile", profile]
        self.process = subprocess.Popen(
            [found(), *flags, "about:blank"], env=os.environ | {"HOME": str(profile)},
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        )  # fmt: skip
        there = wait(lambda: json.loads(Path(profile, "WebDriverBiDiServer.json").read_text()))
        address = f"ws://{there['ws_host']}:{there['ws_port']}/session"
        self.socket = websocket.create_connection(address, timeout=WAIT, suppress_origin=True)
        self.number, self.errors, self.requests = 0, [], []
        self.send("session.new", capabilities={})
        self.send("session.subscribe", events=["network.beforeRequestSent", "log.entryAdded"])
        [page] = self.send("browsingContext.getTree")["contexts"]
        self.page = page["context"]

    def note(self, message):
        method, params = message["method"], message["params"]
        if method == "network.beforeRequestSent":
            self.requests.append(params["request"]["url"])
        elif method == "log.entryAdded" and params["level"] == "error":
            self.errors.append(params["text"])

    def open(self, address):
        """Go to an address and wait until it is there."""
        self.errors.clear()
        self.requests.clear()
        self.send("browsingContext.navigate", context=self.page, url=address, wait="complete")

    def run(self, script):
        """Return the value of an expression, of what it promises if it does."""
        answer = self.send(
            "script.evaluate", expression=f"Promise.resolve({script}).then(JSON.stringify)",
            target={"context": self.page}, awaitPromise=True,
        )  # fmt: skip
        assert answer["type"] == "success", answer["exceptionDetails"]["text"]
        return json.loads(answer["result"].get("value", "null"))

    def save_in(self, folder):
        """Let what pages offer for saving be saved there."""
        behavior = {"type": "allowed", "destinationFolder": str(folder)}
        self.send("browser.setDownloadBehavior", downloadBehavior=behavior)

    def shot(self, box):
        """Return what is seen in a box of the page, as PNG."""
        clip = {"type": "box", **box}
        shot = self.send("browsingContext.captureScreenshot", context=self.page, clip=clip,
                         origin="document")  # fmt: skip
        return base64.b64decode(shot["data"])
