"""What a folder of pages leads to: every address in it, and which of them lead nowhere."""

import re
from functools import cache
from html.parser import HTMLParser
from urllib.parse import unquote, urlsplit

COLOURED = re.compile(r'<span class="\w+">|</span>')  # words of code, most of a page's elements
LOADED = re.compile(r"url\(\s*['\"]?([^'\")]+)|@import\s+['\"]([^'\"]+)")


class Page(HTMLParser):
    """The addresses of a page, what it loads, the names it can be entered by."""

    def __init__(self, path):
        super().__init__()
        self.links, self.loads, self.names, self.unsaid, self.twice = [], [], {""}, [], []
        self.feed(COLOURED.sub("", path.read_text()))

    def handle_starttag(self, tag, attrs):
        values = dict(attrs)
        if values.get("id") in self.names:
            self.twice.append(values["id"])
        self.names |= {values[key] for key in ("id", "name") if key in values}
        if tag == "a" and "href" in values:
            self.links.append(values["href"])
        elif "href" in values:
            self.loads.append(values["href"])
        if "src" in values:
            self.loads.append(values["src"])
        if tag == "img" and not values.get("alt"):
            self.unsaid.append(values.get("src"))
        self.loads += [a or b for a, b in LOADED.findall(values.get("style") or "")]


def faults(folder):
    """Return a sentence for each fault of the pages.

    That is a dead link, a load from elsewhere, a picture without text, a name given twice.

    Parameters
    ----------
    folder : pathlib.Path
        The site; nothing but files below it is looked at.
    """
    folder = folder.resolve()
    pages = {path: Page(path) for path in sorted(folder.rglob("*.html"))}
    told = []

    @cache
    def leads_to(place, address):
        """Return the file below the folder that an address leads to, or None."""
        target = (place / unquote(address)).resolve()
        return target if target.is_file() and target.is_relative_to(folder) else None

    for path, page in pages.items():
        name = path.relative_to(folder)
        for address in page.links + page.loads:
            parts = urlsplit(address)
            if parts.scheme == "data" or (parts.scheme and address in page.links):
                continue
            if parts.scheme or parts.netloc:
                told.append(f"{name} loads {address} from elsewhere")
                continue
            target = leads_to(path.parent, parts.path) if parts.path else path
            if target is None:
                told.append(f"{name} leads to {address}, which isn't there")
            elif target in pages and unquote(parts.fragment) not in pages[target].names:
                told.append(f"{name} leads to {address}, a page without that name")
        told += [f"{name} shows {source} without a text" for source in page.unsaid]
        told += [f"{name} has the name {twice} twice" for twice in page.twice]
    for path in sorted(folder.rglob("*.css")):
        for address in map("".join, LOADED.findall(path.read_text())):
            target = (path.parent / address).resolve()
            if not target.is_file() or not target.is_relative_to(folder.resolve()):
                told.append(f"{path.name} loads {address}, which isn't there")
    return told
