"""JupyterLab in a page: notebooks opened, run, their sliders moved."""

import json
import time

import numpy as np
from chromium import wait

# Trame's client asks for a launcher first, which there is none of; it then goes on without.
EXPECTED = "/paraview/"
RUN = 300  # s, for a notebook on a busy machine
PAUSE = 0.5  # s between two moves, in which a person looks at the picture


class Lab:
    """What a person does in JupyterLab.

    Parameters
    ----------
    browser : Browser
        Its page.
    address : str
        Of the index notebook.
    began : float
        When the server was started, by the monotonic clock.
    """

    def __init__(self, browser, address, began):
        self.browser, self.began = browser, began
        browser.open(address)
        browser.until("!!window.jupyterapp")
        browser.run("jupyterapp.restored.then(() => true)")

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

    def errors(self):
        return [error for error in self.browser.errors if EXPECTED not in error]

    def move(self, times=1):
        """Move the first slider by the keyboard; return the seconds until each new drawing."""
        taken = []
        self.take("!!hand.picture()")
        for k in range(times):
            time.sleep(PAUSE)
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

    def take(self, ready):
        """Lay hands on the first slider."""
        self.browser.run(HAND)
        self.browser.until(ready, RUN)
        self.browser.run("hand.handle().scrollIntoView({block: 'center'})")

    def push(self, k):
        self.browser.run("hand.handle().focus()")  # a scene may take it when it appears
        # There and back, so that no end of the slider is reached.
        self.browser.press(*(("ArrowRight", 39) if k % 2 else ("ArrowLeft", 37)))


# The first slider of the notebook that is open and the picture below it; from the key to the new
# picture the page's own clock runs.
HAND = """
window.hand = {
  handle: () => document.querySelector(".jp-NotebookPanel:not(.lm-mod-hidden) .noUi-handle"),
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
