"""JupyterLab in a page: notebooks opened, run, their sliders moved."""

import json
import time

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
        self.browser.run(
            f"(async () => {{ const w = {self.widget}; await w.sessionContext.shutdown();"
            "w.dispose(); return true; })()"
        )

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

    # The first slider of the notebook that is open, and the picture below it.
    HANDLE = "document.querySelector('.jp-NotebookPanel:not(.lm-mod-hidden) .noUi-handle')"
    PICTURE = f"{HANDLE}?.closest('.jp-OutputArea')?.querySelector('.jp-OutputArea img')?.src"

    def move(self, times=1):
        """Move the first slider by the keyboard; return the seconds until each new picture."""
        browser, taken = self.browser, []
        browser.until(f"!!({self.PICTURE})", RUN)
        browser.run(f"{self.HANDLE}.scrollIntoView({{block: 'center'}})")
        browser.run(f"{self.HANDLE}.focus()")
        for k in range(times):
            before = browser.run(self.PICTURE)
            started = time.monotonic()
            # There and back, so that no end of the slider is reached.
            browser.press(*(("ArrowRight", 39) if k % 2 else ("ArrowLeft", 37)))
            browser.until(f"({self.PICTURE} ?? '') && {self.PICTURE} !== {json.dumps(before)}")
            taken.append(time.monotonic() - started)
        return taken
