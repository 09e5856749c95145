"""axe-core, which looks for what keeps people out of a page: fetched by content, kept in build/."""

import hashlib
import io
import shutil
import subprocess
import tarfile

from report.sources import ROOT

PACKAGE = "axe-core@4.14.1"
# Of the package as npm has it; nothing else is taken.
SHA512 = (
    "1477dafa598d8d065f273d6af302aa203c02e83131707b7fa648cd41bd3d6b73"
    "4f8c22a0dab86ee6a6f64b8afbe804b214d36db85a2826965edfb3a0b9d546b5"
)
SLOW = 400  # s, for the supplement on a busy machine
KEPT = ROOT / "build" / "axe" / "axe-core.tgz"


def provide():
    """Return axe-core as a script.

    Raises
    ------
    LookupError
        If it isn't kept and npm doesn't give it, or gives something else.
    """
    if not KEPT.exists():
        if shutil.which("npm") is None:
            raise LookupError("There is no npm, which fetches axe-core: Debian's package is npm.")
        KEPT.parent.mkdir(parents=True, exist_ok=True)
        pack = ["npm", "pack", PACKAGE, "--silent", "--pack-destination", KEPT.parent]
        ran = subprocess.run(pack, capture_output=True, text=True)
        if ran.returncode:
            raise LookupError(f"npm didn't give {PACKAGE}: {ran.stderr.strip()[-200:]}")
        (KEPT.parent / ran.stdout.split()[-1]).rename(KEPT)
    content = KEPT.read_bytes()
    if hashlib.sha512(content).hexdigest() != SHA512:
        raise LookupError(f"{KEPT} isn't {PACKAGE} as it is known, and isn't used.")
    with tarfile.open(fileobj=io.BytesIO(content)) as package:
        return package.extractfile("package/axe.min.js").read().decode()


def violations(browser, script, *, colours=True):
    """Return a line for each rule that an open page breaks, with the first place.

    Parameters
    ----------
    browser : Browser
        With the page.
    script : str
        As `provide` returns it.
    colours : bool, optional
        Whether letters are compared with what is behind them, which takes half of the time.
    """
    browser.socket.settimeout(SLOW)
    chosen = "resultTypes: ['violations']"
    if not colours:
        chosen += ", rules: { 'color-contrast': { enabled: false } }"
    browser.run(f"{script}; true")
    # What the page does to boxes that scroll it does when they are drawn.
    browser.run("new Promise((done) => requestAnimationFrame(() => setTimeout(done)))")
    return browser.run(
        f"axe.run({{ {chosen} }}).then(({{ violations }}) => violations.map(({{ id, nodes }}) => "
        "`${id} (${nodes.length}): ${nodes[0].html.slice(0, 150)} "
        "${nodes[0].any.concat(nodes[0].all).map((c) => c.message)[0] ?? ''}`))"
    )
