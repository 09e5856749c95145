"""What a reader sees of an equation, what of it is red, and what differs from the printed form."""

from difflib import SequenceMatcher

from report.tests.typst_math import NO_MEANING, closing, tokens


def visible(source):
    """Return what is seen, a pair of text and whether it's marked for each thing.

    A letter and its index are one thing, a power is another; parentheses that a fraction swallows
    aren't seen.

    Examples
    --------
    >>> visible("t_2^mended(2) / (r + 1)")
    [('t_2', False), ('^2', True), ('/', False), ('r', False), ('+', False), ('1', False)]
    """
    given = [t for t in tokens(source) if t.text not in NO_MEANING | {"quad"}]
    hidden = _swallowed(given)
    seen, at = [], 0
    while at < len(given):
        parts, start = [given[at]], at
        if given[at].text in ("^", "_"):
            at += 1
            end = closing(given, at) if given[at].text == "(" else at
            parts += [t for t in given[at : end + 1] if t.text not in ("(", ")")]
            at = end
        text, marked = "".join(t.text for t in parts), any(t.marked for t in parts)
        if parts[0].text == "_":
            letter, red = seen.pop()
            text, marked = letter + text, marked or red
        if start not in hidden:
            seen.append((text, marked))
        at += 1
    while seen[-1][0] in (",", "."):
        seen.pop()
    return seen


def _swallowed(given):
    """Return the places of parentheses that Typst leaves out above or below a fraction's line."""
    places, opened = set(), []
    around = ["", *(t.text for t in given), ""]
    for at, token in enumerate(given):
        if token.text == "(":
            opened.append(at)
        elif token.text == ")" and opened:
            start = opened.pop()
            before, after = around[start], around[at + 2]
            called = not given[start].spaced and before[-1:].isalpha()
            if not called and after not in ("^", "_") and "/" in (before, after):
                places |= {start, at}
    return places


def marked(source):
    """Return the things that are marked, by their places."""
    return {place: text for place, (text, red) in enumerate(visible(source)) if red}


def changed(source, printed):
    """Return the things of a source that its printed form has otherwise or not at all."""
    here, there = ([text for text, _ in visible(form)] for form in (source, printed))
    steps = SequenceMatcher(None, there, here, autojunk=False).get_opcodes()
    places = [i for kind, _, _, start, end in steps if kind != "equal" for i in range(start, end)]
    return {place: here[place] for place in places}
