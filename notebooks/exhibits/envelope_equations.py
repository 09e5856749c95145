"""The document's Eq. 4, term by term, as it is printed and as it is mended."""

import numpy as np


def eq04_terms(f, *, printed=False):
    """Return the terms of Eq. 4 (13, ...), whose sum is 0 where a line lies in the graph of `f`.

    `f` is a jet. Nine terms are mended: as `printed` each of them has lost or changed an index of
    a third derivative.
    """
    a, b, c = (f.derivative(2 - i, i) for i in range(3))
    k, l, m, n = (f.derivative(3 - i, i) for i in range(4))  # noqa: E741
    l1, m1 = (b, b) if printed else (l, m)
    l2 = k if printed else l
    terms = [
        c**3 * k**2,
        6 * c * k * n * b * a,
        -6 * c**2 * k * m1 * a,
        -6 * n * m1 * a**2 * b,
        9 * c * m1**2 * a**2,
        -6 * b * c**2 * l1 * k,
        12 * b**2 * l1 * n * a,
        -18 * b * c * l1 * (n if printed else m) * a,
        12 * c * m1 * b**2 * k,
        -8 * n * b**3 * k,
        9 * a * c**2 * l1**2,
        -6 * c * l2 * n * a**2,
        n**2 * a**3,
    ]
    return np.stack(terms)
