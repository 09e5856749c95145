"""What one or two notebooks show: their pictures, the atlas' sweep, and what the documents print.

Quartics of the torus, ways of meeting a rod with lines and the judge of them in whole numbers,
other interpolators and the conditions for envelopes stand here as the documents have them, to be
run and judged; no tool of the library uses them.
"""
