"""Small faults planted in displayed equations, one a time, of the kinds that typesetting makes."""

from report.tests.typst_math import LETTERS, PLAIN, tokens

SWAPS = {
    "+": "-", "-": "+", "<": ">", ">": "<", "<=": ">=", ">=": "<=", "sin": "cos", "cos": "sin",
    "tan": "sin", "arcsin": "arccos", "arccos": "arcsin", "arctan": "arcsin",
}  # fmt: skip


def places(given):
    """Return for each token whether it stands in an index, in an exponent or on the line."""
    found, depth, raised = [], 0, []
    for token, before in zip(given, [None, *given], strict=False):
        here = raised[-1][0] if raised else "line"
        if before and before.text in ("_", "^"):
            here = {"_": "index", "^": "exponent"}[before.text]
            if token.text == "(":
                raised.append((here, depth))
        found.append(here)
        depth += (token.text == "(") - (token.text == ")")
        if raised and token.text == ")" and depth == raised[-1][1]:
            raised.pop()
    return found


def faults(source, rng):
    """Return every fault as its kind, the place of its token and the tokens with it.

    Where there's a choice, as of another letter, the generator chooses.
    """
    given = tokens(source)
    where = places(given)
    letters = _letters(given, where, "line")
    indices = _letters(given, where, "index")
    result = []
    for i, (token, place) in enumerate(zip(given, where, strict=True)):
        for kind, text in _changes(token, place, letters, indices, rng):
            changed = [token._replace(text=text)] if text else []
            alone = not text and i and given[i - 1].text in ("_", "^")
            start = i - 1 if alone else i  # a lost index takes its _ along
            result.append((kind, i, [*given[:start], *changed, *given[i + 1 :]]))
    return result


def _letters(given, where, place):
    found = {t.text for t, here in zip(given, where, strict=True) if here == place and _letter(t)}
    return sorted(found)


def _letter(token):
    return token.kind == "word" and (len(token.text) == 1 or token.text in LETTERS)


def _changes(token, place, letters, indices, rng):
    """Yield the kind of each change of a token, and its new text, none where it's lost."""
    if token.text in SWAPS:
        yield ("function" if token.text in PLAIN else "sign"), SWAPS[token.text]
    if token.kind == "number":
        kind = {"line": "coefficient"}.get(place, place)
        yield kind, str(int(token.text) + 1)
        yield f"lost {kind}", ""
    if _letter(token) and place in ("line", "index"):
        others = [t for t in (letters if place == "line" else indices) if t != token.text]
        if others:
            yield ("letter" if place == "line" else "index"), str(rng.choice(others))
