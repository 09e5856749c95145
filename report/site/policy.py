"""What a page of the site may load and run: a Content-Security-Policy, in the page itself.

Pages are opened as files or from a server: ``'self'`` is the server, ``file:`` the files.
"""

import base64
import hashlib

from report.site.scenes import viewer_style

OWN = "'self' file:"


def content_policy(style="", *, runs=False):
    """Return the policy of a page.

    Parameters
    ----------
    style : str
        What stands in the page's element <style>, if anything.
    runs : bool
        Whether Python runs in the page: its Worker imports a module that the page hands over.

    Returns
    -------
    policy : str
        Scripts come from the site's own files alone: none stands in a page, and none is made of a
        text. Workers made by these scripts may run, and WebAssembly may. Elements <style> are
        known by their digests, the viewer's, too, which it makes when a scene is shown. Attributes
        style are let through: Typst and MathML use hundreds, and a digest of each would say no
        more than that. Nothing is fetched, framed or sent.
    """
    styles = " ".join(map(digest, filter(None, (style, viewer_style()))))
    return "; ".join(
        [
            "default-src 'none'",
            f"script-src {OWN} 'wasm-unsafe-eval'" + (" blob:" if runs else ""),
            "worker-src blob:",
            f"style-src {OWN} {styles}",
            "style-src-attr 'unsafe-inline'",
            f"img-src {OWN} data: blob:",
            f"font-src {OWN}",
            "base-uri 'none'",
            "form-action 'none'",
        ]
    )


def digest(text):
    """Return an inline text as a policy names it."""
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}'"
