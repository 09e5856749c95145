"""JupyterLab in a page: notebooks opened, run, their sliders moved."""

import json

# Trame's client asks for a launcher first, which there is none of; it then goes on without.
EXPECTED = "/paraview/"
RUN = 300  # s, for a notebook on a busy machine


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
        # A promise that nothing holds may be collected before it comes true.
        self.browser.run(
            f"window.left = {self.widget};"
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
        """Move the first slider by the keyboard; return the seconds until each new picture."""
        browser, taken = self.browser, []
        browser.run(HAND)
        browser.until("!!hand.picture()", RUN)
        browser.run("hand.handle().scrollIntoView({block: 'center'})")
        browser.run("hand.handle().focus()")
        for k in range(times):
            browser.run("hand.watch()")
            # There and back, so that no end of the slider is reached.
            browser.press(*(("ArrowRight", 39) if k % 2 else ("ArrowLeft", 37)))
            taken.append(browser.until("hand.taken") / 1000)
        return taken


# The first slider of the notebook that is open and the picture below it; from the key to the new
# picture the page's own clock runs.
HAND = """
window.hand = {
  handle: () => document.querySelector(".jp-NotebookPanel:not(.lm-mod-hidden) .noUi-handle"),
  area: () => hand.handle()?.closest(".jp-OutputArea"),
  picture: () => hand.area()?.querySelector(".jp-OutputArea img")?.src,
  watch: () => {
    const before = hand.picture();
    hand.taken = 0;
    addEventListener("keydown", () => (hand.began = performance.now()),
                     { capture: true, once: true });
    new MutationObserver((_, observer) => {
      const now = hand.picture();
      if (!now || now === before) return;
      observer.disconnect();
      hand.taken = performance.now() - hand.began;
    }).observe(hand.area(), { subtree: true, childList: true, attributes: true });
  },
};
true"""
