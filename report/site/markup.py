"""Text to HTML: a notebook's Markdown with its formulas as MathML, code with its colours."""

import re
from functools import cache
from html import escape, unescape
from xml.etree.ElementTree import Element, tostring

from latex2mathml.converter import convert_to_element
from nbconvert.filters.markdown_mistune import IPythonRenderer, MarkdownWithMath
from pygments import highlight
from pygments.formatters import HtmlFormatter
from pygments.lexers import get_lexer_by_name

CODE = HtmlFormatter(cssclass="code")
_lexer = cache(get_lexer_by_name)
FUNCTIONS = {"sin", "cos", "tan", "arcsin", "arccos", "arctan", "log"}
CLOSING = {"&#x00029;", "&#x0005D;"}
# The one piece of HTML that is let through: an answer to unfold, its title without any markup.
UNFOLDED = re.compile(r"\s*(?:<details>\s*<summary>[^<>]*</summary>|</details>)\s*")


def formula(latex, display="inline"):
    """Return a formula as MathML, which browsers set and screen readers speak by themselves."""
    made = convert_to_element(latex.strip(), display=display)
    for row in list(made.iter("mrow")):
        _space_functions(row)
    # Its signs are character references already; a text's < must stay escaped.
    return re.sub(r"&amp;(#x[0-9A-Fa-f]+;)", r"&\1", tostring(made, encoding="unicode"))


def _space_functions(row):
    """Set functions in a row of a formula apart from what they stand by, signs excepted."""
    parts = list(row)
    for at in reversed(range(1, len(parts))):
        left, right = parts[at - 1], parts[at]
        after = _is_function(left) and right.tag != "mo"
        before = _is_function(right) and (left.tag != "mo" or left.text in CLOSING)
        if after or before:
            row.insert(at, Element("mspace", width="0.17em"))


def _is_function(part):
    """Tell whether a part of a formula is a function's name, perhaps with an exponent."""
    name = part[0] if part.tag == "msup" else part
    return name.tag == "mi" and name.text in FUNCTIONS


class Renderer(IPythonRenderer):
    """Markdown as Jupyter reads it; its links lead to pages of the site.

    HTML in it is shown as it is written, but for answers that a click unfolds.
    """

    def __init__(self, link):
        super().__init__(escape=True, allow_harmful_protocols=False, exclude_anchor_links=True)
        self.follow = link

    def block_mermaidjs(self, code):
        return f"<pre>{escape(code)}</pre>\n"  # else it would be let through as it is

    def block_html(self, html):
        return html if UNFOLDED.fullmatch(html) else super().block_html(html)

    def heading(self, text, level, **attrs):
        return f'<h{level} id="{anchor(text)}">{text}</h{level}>\n'

    def link(self, text, url, title=None):
        return super().link(text, self.follow(url), title)

    def block_math(self, body):
        return formula(body, "block")

    def inline_math(self, body):
        return formula(body)


def markdown(text, link=str):
    """Return Markdown as HTML, each link's target given by a function of what is written."""
    return MarkdownWithMath(renderer=Renderer(link)).render(text)


@cache  # a second set of pages shows the same
def code(text, language="python"):
    """Return code in colours; ``pycon`` is an example with its answers."""
    return highlight(text, _lexer(language), CODE)


def anchor(text):
    """Return a heading's name in links.

    Examples
    --------
    >>> anchor("Noise <em>(Example 32)</em>")
    'noise-example-32'
    """
    return "-".join(re.findall(r"\w+", re.sub(r"<[^>]*>", "", text).lower()))


def plain(html):
    """Return what a page's text says, without its marks.

    Examples
    --------
    >>> plain("<p>a<b>b</b></p><p>c</p>")
    'ab c'
    """
    html = re.sub(r"<(script|style)\b.*?</\1>", " ", html, flags=re.S)
    html = re.sub(r"</?(?:p|h\d|li|td|th|tr|dt|dd|div|pre|br|figcaption)\b[^>]*>", " ", html)
    return " ".join(unescape(re.sub(r"<[^>]*>", "", html)).split())


def breakable(name):
    """Return a name in code as HTML that a narrow screen breaks between its parts.

    Examples
    --------
    >>> breakable("paths.inverse_problem")
    'paths.<wbr>inverse_<wbr>problem'
    """
    return re.sub(r"(?<=\w[._])(?=\w)", "<wbr>", name)


def attribute(text):
    """Return text as it stands in an attribute's quotation marks."""
    return escape(text, quote=True)
