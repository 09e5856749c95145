"""What the three documents print, kept runnable and judged; no tool of the library uses it.

Quartics of the torus, ways of meeting a rod with lines and the judge of them in whole numbers,
other interpolators, the conditions for envelopes as they stand.
"""

from . import envelope_equations, interpolators, quartics, rod_cases, rod_exact, rod_methods

__all__ = [
    "envelope_equations",
    "interpolators",
    "quartics",
    "rod_cases",
    "rod_exact",
    "rod_methods",
]
