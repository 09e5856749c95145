"""Put on PYTHONPATH, this is imported at Python's start: numpy with another rounding.

sin, exp and their like are not rounded rightly everywhere: their last bit depends on the processor
and on who wrote them. Here half of their results, told by the results themselves, are the next
number up or down; exact ones, such as cos(0) or arctan2(0, -1), stay. What the study prints must
stay, too: `PYTHONPATH=$PWD/tests/audit/noise make test TESTS=notebooks`.
"""

try:
    import numpy as np
except ImportError:
    np = None

NAMES = (
    "sin cos tan arcsin arccos arctan arctan2 sinh cosh tanh arcsinh arccosh arctanh exp exp2 "
    "expm1 log log2 log10 log1p hypot cbrt"
).split()


MANTISSA = 2**52 - 1  # what a power of two as a factor leaves alone


class Noisy:
    """A function of numpy whose last bit is another."""

    def __init__(self, exact):
        self.exact = exact

    def __call__(self, *arguments, out=None, **options):
        result = self.exact(*arguments, **options)
        if isinstance(result, np.float64 | np.ndarray) and result.dtype == np.float64:
            bits = np.asarray(result).view(np.int64)
            with np.errstate(over="ignore"):  # the product is meant to overflow
                step = ((bits & MANTISSA) * 0x9E3779B97F4A7C1) >> 62  # -2, -1, 0 or 1
            short = bits & 0xFFFFF == 0  # few digits: exact, such as hypot(3, 4) or log2(8)
            kept = short | np.isin(np.abs(result), KEPT) | ~np.isfinite(result)
            moved = (bits + np.where(kept, 0, np.clip(step, -1, 1))).view(np.float64)
            result = moved if isinstance(result, np.ndarray) else moved[()]
        if out is None:
            return result
        target = out[0] if isinstance(out, tuple) else out
        where = options.get("where", True)
        np.copyto(target, result, where=where)
        return target

    def __getattr__(self, name):
        return getattr(self.exact, name)

    def __eq__(self, other):
        return other is self or other is self.exact

    def __hash__(self):
        return hash(self.exact)


if np is not None:
    KEPT = np.array([np.pi, np.pi / 2, np.pi / 4, 3 * np.pi / 4])
    for name in NAMES:
        setattr(np, name, Noisy(getattr(np, name)))
