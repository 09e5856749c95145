"""Random jets for the tests of what is read off them."""

import numpy as np

from tunneller_lib.envelopes.jet import EXPONENTS, Jet


def jet_of(n, seed):
    """Return a jet of order 4 with random coefficients at n points."""
    return Jet(np.random.default_rng(seed).normal(size=(len(EXPONENTS), n)))
