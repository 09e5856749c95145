"""The document's quartics, Eqs 5 and 10, with their coefficients corrected.

The library itself uses closed forms (`Torus.feet`) and brackets (`torus_line`) instead.
"""

import numpy as np

from tunneller_lib.kernels.exact import dot


def line_quartic(torus, a, b):
    """Return the coefficients of the quartic in t for a line a + t (b - a) (Eq. 5).

    Parameters
    ----------
    torus : Torus
        The surface.
    a, b : (..., 3) float
        Two points of each line, in m.

    Returns
    -------
    coefficients : (..., 5) float
        T4, T3, T2, T1, T0, in m^4.

    Notes
    -----
    Corrected: T2 has 4 t3^2 (printed 2 t3^2) and T0 has t2^2 (printed t2).
    """
    a, b = np.broadcast_arrays(np.asarray(a, dtype=float), b)
    u = b - a
    # With p = a + t u, |p|^2 - r^2 - R^2 is t4 t^2 + 2 t3 t + t2, and Eq. 4 says that its square
    # is 4 r^2 (R^2 - y^2).
    t4 = dot(u, u)
    t3 = dot(a, u)
    t2 = dot(a, a) - torus.r**2 - torus.R**2
    ring = 4 * torus.r**2
    a2 = a[..., 1]
    u2 = u[..., 1]
    coefficients = [
        t4**2,
        4 * t3 * t4,
        ring * u2**2 + 2 * t2 * t4 + 4 * t3**2,
        2 * ring * a2 * u2 + 4 * t2 * t3,
        t2**2 - ring * (torus.R**2 - a2**2),
    ]
    return np.stack(coefficients, axis=-1)


def meet_line(torus, a, b):
    """Return where lines through a and b (..., 3) meet a torus, as `Torus.meet_line` does.

    By the eigenvalues of Eq. 5's companion matrix: (..., 4) ascending, NaN-padded.
    """
    return real_roots(line_quartic(torus, a, b))


def foot_quartic(torus, m):
    """Return the coefficients of the quartic in n1 of the tangent-sphere feet (Eqs 10 and 11).

    Parameters
    ----------
    torus : Torus
        The surface.
    m : (..., 3) float
        Centres M of the spheres, in m, off the plane m1 = 0, where every coefficient but the
        first vanishes.

    Returns
    -------
    coefficients : (..., 5) float
        N4, N3, N2, N1, N0, without the document's common factor m1^4.

    Notes
    -----
    Corrected: N4 has (m1^2 + m3^2)^2; the last bracket of nu4 has m2^2 + m3^2; nu0 has
    (r^2 - R^2)^2 before its first bracket, no m3^2 behind it, and (r^2 - R^2) within its last.
    Written in s = m1^2 + m3^2, in which all three are polynomials.
    """
    m1, m2, m3 = np.moveaxis(np.asarray(m, dtype=float), -1, 0)
    rr = torus.r**2
    RR = torus.R**2
    s = m1**2 + m3**2
    m11 = m1**2
    m22 = m2**2
    nu4 = (s - rr) ** 2 + 2 * (s + rr) * m22 + m22**2
    nu2 = (rr + RR) * (s - rr) ** 2 + (2 * rr + RR) * (s + rr) * m22 + rr * m22**2
    nu0 = ((rr - RR) * (s - rr)) ** 2 + 2 * rr * (rr - RR) * (s + rr) * m22 + (rr * m22) ** 2
    coefficients = [
        s**2 * nu4,
        np.zeros_like(s),
        -2 * m11 * s * nu2,
        8 * rr * RR * s * m1**3 * m22,
        m11**2 * nu0,
    ]
    return np.stack(coefficients, axis=-1)


def real_roots(coefficients, *, threshold=2.0**-26):
    """Return the real roots (..., n) of polynomials, ascending and NaN-padded.

    Parameters
    ----------
    coefficients : (..., n + 1) float
        Highest power first. Rows that aren't finite, or begin with zero, have no roots.
    threshold : float, or an array that broadcasts with (..., 1)
        Largest imaginary part of a root that counts as real, as a share of the largest root.
        Rounding alone gives a double root one of the order of the default, the square root
        of the unit in the last place.

    Returns
    -------
    roots : (..., n) float
        Real parts of eigenvalues of the companion matrix, for all thresholds.

    Examples
    --------
    Beside a root of 2^26 one of 1.5i isn't real, and one of 0.7i is real but for rounding:

    >>> large = 2.0**26
    >>> for square in (2.25, 0.49):
    ...     int(np.isfinite(real_roots([1.0, -large, square, -square * large])).sum())
    1
    3
    """
    coefficients = np.asarray(coefficients, dtype=float)
    n = coefficients.shape[-1] - 1
    with np.errstate(all="ignore"):
        monic = coefficients[..., 1:] / coefficients[..., :1]
    finite = np.all(np.isfinite(monic), axis=-1, keepdims=True)
    companion = np.zeros((*monic.shape[:-1], n, n))
    companion[..., np.arange(1, n), np.arange(n - 1)] = 1
    companion[..., :, -1] = -np.where(finite, monic, 0)[..., ::-1]
    roots = np.linalg.eigvals(companion)
    size = np.max(np.abs(roots), axis=-1, keepdims=True, initial=0)
    is_real = np.abs(roots.imag) <= threshold * size
    return np.sort(np.where(is_real & finite, roots.real, np.nan), axis=-1)
