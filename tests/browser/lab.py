"""JupyterLab in a page: notebooks opened, run, their sliders moved."""

import json
import os
import shutil
import socket
import subprocess
import time
from contextlib import contextmanager
from urllib.error import URLError
from urllib.request import urlopen

import numpy as np
import psutil
from chromium import wait

from report.sources import ROOT

# Trame's client asks for a launcher first, which there is none of; it then goes on without.
EXPECTED = "/paraview/"
RUN = 300  # s, for a notebook on a busy machine
PAUSE = 0.5  # s between two moves, in which a person looks at the picture


@contextmanager
def started(browser, root):
    """Have JupyterLab as `make lab` starts it, on a copy of what the notebooks need.

    Parameters
    ----------
    browser : Browser
        For its page.
    root : pathlib.Path
        An empty folder for the copy.
    """
    for folder in ("notebooks", "figures", "tests/references", "report/numbers"):
        shutil.copytree(ROOT / folder, root / folder)
    (root / ".venv").symlink_to(ROOT / ".venv")
    environment = {k: v for k, v in os.environ.items() if k != "PYVISTA_JUPYTER_BACKEND"}
    environment |= {"TUNNELLER_RESULTS": str(root), "JUPYTERLAB_WORKSPACES_DIR": str(root / "w")}
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    asked = ["make", "--no-print-directory", "--dry-run", "lab"]
    told = subprocess.run(asked, cwd=ROOT, capture_output=True, text=True, check=True)
    lines = told.stdout.replace("\\\n", "").splitlines()
    (command,) = (line for line in lines if "jupyter lab" in line)
    options = (f"--no-browser --port={port} --IdentityProvider.token= "
               "--LabApp.expose_app_in_browser=True")  # fmt: skip
    began = time.monotonic()
    server = subprocess.Popen(f"exec env {command} {options}", shell=True, cwd=root,
                              env=environment, stdout=subprocess.DEVNULL,
                              stderr=subprocess.DEVNULL)  # fmt: skip
    address = f"http://localhost:{port}"
    try:
        wait(lambda: server.poll() is not None or answers(f"{address}/api"))
        assert server.poll() is None, f"JupyterLab ended at once: {command} {options}"
        index = f"{address}/lab/tree/notebooks/00_index.ipynb"
        yield Lab(browser, root, index, began, psutil.Process(server.pid))
    finally:
        server.terminate()
        server.wait()


def answers(address):
    try:
        return urlopen(address).status == 200
    except URLError:
        return False


class Lab:
    """What a person does in JupyterLab.

    Parameters
    ----------
    browser : Browser
        Its page.
    root : pathlib.Path
        The folder that JupyterLab is on.
    address : str
        Of the index notebook.
    began : float
        When the server was started, by the monotonic clock.
    server : psutil.Process
        The server, whose children the kernels are.
    """

    def __init__(self, browser, root, address, began, server):
        self.browser, self.root, self.began, self.server = browser, root, began, server
        self.host = address.split("/")[2]
        browser.open(address)
        browser.until("!!window.jupyterapp")
        browser.run("jupyterapp.restored.then(() => true)")
        # The first page opens late, and would come before a notebook that is opened at once.
        browser.until("[...jupyterapp.shell.widgets('main')].some(w => w.context?.isReady)")

    def open(self, path):
        """Open a notebook and wait for its kernel."""
        self.browser.errors.clear()
        self.browser.requests.clear()
        self.path = path
        self.browser.run(
            f"jupyterapp.commands.execute('docmanager:open', {{path: {json.dumps(path)}}})"
            ".then(() => true)"
        )
        self.widget = (
            "[...jupyterapp.shell.widgets('main')]"
            f".find(w => w.context && w.context.path === {json.dumps(path)})"
        )
        self.browser.until(f"{self.widget}.sessionContext.session?.kernel?.status === 'idle'")

    def close(self):
        # Its scenes first, which would look for a kernel that's gone. A promise that nothing holds
        # may be collected before it comes true.
        self.browser.run(
            f"window.left = {self.widget};"
            "left.node.querySelectorAll('iframe').forEach(scene => scene.remove());"
            "window.leaving = left.sessionContext.shutdown().then(() => left.dispose()); true"
        )
        self.browser.until("left.isDisposed")

    def start(self):
        """Have all cells run."""
        self.browser.run(f"jupyterapp.shell.activateById({self.widget}.id)")
        self.browser.run(f"{self.widget}.content.deselectAll()")
        self.browser.run("void jupyterapp.commands.execute('notebook:run-all-cells')")

    def finish(self):
        """Wait for the last cell; return what went wrong in any."""
        self.browser.until(
            f"{self.widget}.content.widgets.filter(w => w.model.type === 'code' && "
            "w.model.sharedModel.source).every(w => w.model.executionCount && "
            "w.model.executionState === 'idle')",
            RUN,
        )
        return self.browser.run(
            f"{self.widget}.content.widgets.filter(w => w.model.type === 'code')"
            ".flatMap(w => w.model.outputs.toJSON())"
            ".filter(o => o.output_type === 'error' || o.name === 'stderr')"
            ".map(o => o.evalue || o.text)"
        )

    def processor_seconds(self):
        """Return the time that processors worked for the server and its kernels so far, in s."""
        times = [one.cpu_times() for one in (self.server, *self.server.children(recursive=True))]
        return sum(one.user + one.system for one in times)

    def errors(self):
        return [error for error in self.browser.errors if EXPECTED not in error]

    def sliders(self):
        """Return for each cell that has sliders the words beside them."""
        self.browser.run(HAND)
        return self.browser.run("hand.words()")

    def move(self, times=1, which=0, pause=PAUSE):
        """Move a slider by the keyboard; return the seconds until each new drawing."""
        taken = []
        self.take("!!hand.picture()", which)
        for k in range(times):
            time.sleep(pause)
            self.browser.run("hand.watch(); true")
            self.push(k)
            taken.append(self.browser.run("hand.taken") / 1000)
        return taken

    def move_scene(self, times=1):
        """Move the first slider by the keyboard; return the seconds until the scene changes."""
        scene, taken = "hand.scene()", []
        self.take(f"!!{scene}")
        # What is inside comes from another address: it can only be looked at.
        wait(lambda: self.browser.picture(scene).std() > 3, said="a picture of the scene")
        for k in range(times):
            time.sleep(PAUSE)
            before = self.browser.picture(scene)
            began = time.monotonic()
            self.push(k)
            wait(lambda old=before: np.any(self.browser.picture(scene) != old), said="another one")
            taken.append(time.monotonic() - began)
        return taken

    def take(self, ready, which=0):
        """Lay hands on a slider."""
        self.browser.run(HAND)
        self.browser.run(f"hand.which = {which}")
        self.browser.until(ready, RUN)
        self.at_its_end = self.browser.run(
            "hand.handle().ariaValueNow === hand.handle().ariaValueMin"
        )
        self.browser.run("hand.handle().scrollIntoView({block: 'center'})")

    def push(self, k):
        self.browser.run("hand.handle().focus()")  # a scene may take it when it appears
        # There and back, so that no end of the slider is passed.
        right = bool(k % 2) != self.at_its_end
        self.browser.press(*(("ArrowRight", 39) if right else ("ArrowLeft", 37)))


# One of the sliders of the notebook that is open and the picture below it; from the key to the new
# picture the page's own clock runs.
HAND = """
window.hand = {
  which: 0,
  all: (what, within) => [...within.querySelectorAll(what)],
  panel: () => document.querySelector(".jp-NotebookPanel:not(.lm-mod-hidden)"),
  handle: () => hand.all(".noUi-handle", hand.panel())[hand.which],
  words: () => hand.all(".jp-CodeCell", hand.panel())
    .map((cell) => hand.all(".widget-slider .widget-label", cell).map((word) => word.textContent))
    .filter((words) => words.length),
  area: () => hand.handle()?.closest(".jp-OutputArea"),
  scene: () => hand.area()?.querySelector("iframe.pyvista"),
  picture: () => hand.area()?.querySelector(".jp-OutputArea img")?.src,
  watch: () => {
    const before = hand.picture();
    addEventListener("keydown", () => (hand.began = performance.now()),
                     { capture: true, once: true });
    hand.taken = new Promise((told) => {
      new MutationObserver((_, observer) => {
        const now = hand.picture();
        if (!now || now === before) return;
        observer.disconnect();
        told(performance.now() - hand.began);
      }).observe(hand.area(), { subtree: true, childList: true, attributes: true });
    });
  },
};
true"""
