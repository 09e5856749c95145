"""The library's reference, from its docstrings: a page for each module, nothing imported."""

import ast
import re
from dataclasses import dataclass, field
from html import escape
from textwrap import dedent

from report.site.markup import breakable, code
from report.sources import ROOT

LIBRARY = ROOT / "tunneller_lib"
SECTION = re.compile(r"^(\w[\w ]*)\n-{3,}\n", re.M)
LISTS = {"Parameters", "Returns", "Yields", "Attributes", "Raises"}
# From the top, as a reader comes down.
ROOMS = [
    "job", "ream", "milling", "motion", "removal", "paths", "envelopes", "surfaces", "kernels",
]  # fmt: skip


@dataclass
class Entry:
    """A public name: how it is called and what its docstring says."""

    name: str
    signature: str
    docstring: str
    members: list = field(default_factory=list)


@dataclass
class Module:
    """One module and what is public in it."""

    name: str
    docstring: str
    entries: list

    @property
    def page(self):
        return f"library/{self.name.removeprefix('tunneller_lib.')}.html"

    @property
    def short(self):
        return self.name.removeprefix("tunneller_lib.")


def modules(folder=LIBRARY):
    """Return the modules that have something public, room by room."""
    found = []
    for path in sorted(folder.rglob("*.py")):
        tree = ast.parse(path.read_text())
        name = ".".join(path.relative_to(folder.parent).with_suffix("").parts)
        if entries := list(public(tree)):
            found.append(Module(name, ast.get_docstring(tree), entries))
    return sorted(found, key=lambda m: (room_rank(m), m.name))


def room(module):
    """Return the room of a module, or none for those that stand beside the rooms."""
    first, _, rest = module.short.partition(".")
    return first if rest else ""


def room_rank(module):
    return ROOMS.index(room(module)) if room(module) in ROOMS else len(ROOMS)


def public(tree, prefix=""):
    """Yield an entry for every public class and function of a module or class."""
    for node in tree.body:
        if not isinstance(node, ast.ClassDef | ast.FunctionDef):
            continue
        special = prefix and node.name == "__call__"
        if node.name.startswith("_") and not special:
            continue
        name = prefix + node.name
        if isinstance(node, ast.ClassDef):
            members = list(public(node, f"{name}."))
            yield Entry(name, f"{name}({fields(node)})", ast.get_docstring(node) or "", members)
        else:
            yield Entry(name, called(node, name), ast.get_docstring(node) or "")


def called(node, name):
    """Return how a function is called; a property is read."""
    if any(isinstance(d, ast.Name) and d.id == "property" for d in node.decorator_list):
        return name
    arguments = ast.unparse(node.args).removeprefix("self").removeprefix(", ")
    return f"{name}({arguments})"


def fields(node):
    """Return a class's arguments: those of its __init__, or its fields."""
    for inner in node.body:
        if isinstance(inner, ast.FunctionDef) and inner.name == "__init__":
            return ast.unparse(inner.args).removeprefix("self").removeprefix(", ")
    annotated = [inner for inner in node.body if isinstance(inner, ast.AnnAssign)]
    return ", ".join(
        i.target.id + (f"={ast.unparse(i.value)}" if i.value else "") for i in annotated
    )


class Reference:
    """Pages of all modules, which know each other's names."""

    def __init__(self, found):
        self.modules = found
        everywhere = [
            (each.name, f"{module.page}#{each.name}")
            for module in found for entry in module.entries for each in (entry, *entry.members)
        ]  # fmt: skip
        names = [name for name, _ in everywhere]
        self.targets = {name: page for name, page in everywhere if names.count(name) == 1}

    def index(self):
        """Return the body of the library's first page."""
        parts = [
            "<h1>The library</h1>",
            "<p>Metres, radians and seconds; points are arrays (..., 3), joint positions (..., 2) "
            "as (theta, phi); leading axes broadcast. A room imports only from rooms below it.</p>",
        ]
        seen = None
        for module in self.modules:
            if room(module) != seen:
                parts += ["</dl>"] * (seen is not None)
                seen = room(module)
                parts.append(f"<h2 id='{seen or 'beside'}'>{seen or 'below and above'}</h2><dl>")
            names = ", ".join(
                f'<a href="../{module.page}#{e.name}">{e.name}</a>' for e in module.entries
            )
            parts.append(
                f'<dt><a href="../{module.page}">{module.short}</a></dt>'
                f"<dd>{inline(module.docstring.split(chr(10) * 2)[0])}<br>{names}</dd>"
            )
        return "\n".join([*parts, "</dl>"])

    def body(self, module):
        """Return the body of a module's page."""
        own = {e.name: f"{module.page}#{e.name}" for e in module.entries}
        text = self.text(module.docstring, self.targets | own)
        parts = [f"<h1>{breakable(module.short)}</h1>", text]
        for entry in module.entries:
            members = {m.name.partition(".")[2]: f"{module.page}#{m.name}" for m in entry.members}
            scope = self.targets | own | members
            parts.append(self.entry(entry, 2, scope))
            parts += [f'<div class="member">{self.entry(m, 3, scope)}</div>' for m in entry.members]
        return "\n".join(parts)

    def entry(self, entry, level, scope):
        heading = f'<h{level} id="{entry.name}">{breakable(entry.name)}</h{level}>'
        signature = f'<div class="signature">{code(entry.signature)}</div>'
        return f"{heading}\n{signature}\n{self.docstring(entry.docstring, level + 1, scope)}"

    def docstring(self, text, level, scope):
        """Return a numpydoc docstring as HTML, its headings' level and names' scope given."""
        first, *rest = SECTION.split(text)
        parts = [self.text(first, scope)]
        for name, content in zip(rest[::2], rest[1::2], strict=True):
            body = (self.listed if name in LISTS else self.text)(content, scope)
            parts.append(f'<h{level} class="part">{name}</h{level}>\n{body}')
        return "\n".join(parts)

    def listed(self, text, scope):
        """Return a section of terms and indented explanations."""
        parts = []
        for block in re.split(r"\n(?=\S)", text.strip("\n")):
            term, _, told = block.partition("\n")
            parts.append(f"<dt>{escape(term)}</dt><dd>{self.text(dedent(told), scope)}</dd>")
        return f"<dl>{''.join(parts)}</dl>"

    def text(self, text, scope):
        """Return paragraphs and examples."""
        parts = []
        for block in re.split(r"\n\s*\n", text.strip("\n")):
            if block.lstrip().startswith(">>>"):
                parts.append(code(dedent(block), "pycon"))
            elif block.startswith("    "):
                parts.append(f"<pre>{escape(dedent(block))}</pre>")
            elif block.strip():
                parts.append(f"<p>{inline(block, scope)}</p>")
        return "\n".join(parts)


def inline(text, scope=None):
    """Return a paragraph with its code set as such, and the names that a scope knows linked."""

    def name(match):
        said = match[1] or match[2]
        target = (scope or {}).get(said.rstrip("()"))
        return (
            f'<a href="../{target}"><code>{said}</code></a>' if target else f"<code>{said}</code>"
        )

    text = re.sub(r"``(.+?)``|`([^`]+)`", name, escape(text, quote=False))
    return re.sub(r"(?<![\w*])\*(\w[^*]*\w)\*(?![\w*])", r"<em>\1</em>", text)
