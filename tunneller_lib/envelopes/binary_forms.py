"""Forms in two variables h and k, of degree 1 to 4: arithmetic on numbers or arrays.

A form of degree d is the tuple of its coefficients of h^d, h^(d-1) k, ... to k^d: numbers, or
arrays with one value a point. Each function says the degrees of what it takes, so that loops of
plain numbers can be compiled (`compiled`).
"""


def product11(p, q):
    """Return the product of two forms of degree 1."""
    return (p[0] * q[0], p[0] * q[1] + p[1] * q[0], p[1] * q[1])


def plus12(z, p, q):
    """Return z + p q, of degrees 3, 1 and 2."""
    return (
        z[0] + p[0] * q[0],
        z[1] + (p[0] * q[1] + p[1] * q[0]),
        z[2] + (p[0] * q[2] + p[1] * q[1]),
        z[3] + p[1] * q[2],
    )


def plus13(z, p, q):
    """Return z + p q, of degrees 4, 1 and 3."""
    return (
        z[0] + p[0] * q[0],
        z[1] + (p[0] * q[1] + p[1] * q[0]),
        z[2] + (p[0] * q[2] + p[1] * q[1]),
        z[3] + (p[0] * q[3] + p[1] * q[2]),
        z[4] + p[1] * q[3],
    )


def plus22(z, p, q):
    """Return z + p q, of degrees 4, 2 and 2."""
    return (
        z[0] + p[0] * q[0],
        z[1] + (p[0] * q[1] + p[1] * q[0]),
        z[2] + (p[0] * q[2] + p[1] * q[1] + p[2] * q[0]),
        z[3] + (p[1] * q[2] + p[2] * q[1]),
        z[4] + p[2] * q[2],
    )


def plus(p, b, q):
    """Return p + b q of degree 2, with a number b."""
    return (p[0] + b * q[0], p[1] + b * q[1], p[2] + b * q[2])


def sum1(a, p, b, q):
    """Return a p + b q of degree 1, with numbers a and b."""
    return (a * p[0] + b * q[0], a * p[1] + b * q[1])


def sum2(a, p, b, q):
    """Return a p + b q of degree 2, with numbers a and b."""
    return (a * p[0] + b * q[0], a * p[1] + b * q[1], a * p[2] + b * q[2])


def sum3(a, p, b, q):
    """Return a p + b q of degree 3, with numbers a and b."""
    return (a * p[0] + b * q[0], a * p[1] + b * q[1], a * p[2] + b * q[2], a * p[3] + b * q[3])


def replaced2(p, squares):
    """Return a form p of degree 2 with other forms put for h and k, given these forms' `squares`.

    Those are the products of the first by itself, of both, and of the second by itself.
    """
    return plus(sum2(p[0], squares[0], p[1], squares[1]), p[2], squares[2])


def replaced3(p, h, k, squares):
    """Return a form p of degree 3 with forms h and k put for its variables.

    Their `squares` are as for `replaced2`.
    """
    # p is (p0 h + p1 k) h^2 + (p2 h + p3 k) k^2; `none` is a zero of the points' shape.
    none = 0.0 * p[0]
    first = plus12((none, none, none, none), sum1(p[0], h, p[1], k), squares[0])
    return plus12(first, sum1(p[2], h, p[3], k), squares[2])


def replaced4(p, squares):
    """Return what `replaced2` does, of a form p of degree 4."""
    # p is (p0 h^2 + p1 h k + p2 k^2) h^2 + (p3 h k + p4 k^2) k^2.
    none = 0.0 * p[0]
    first = plus(sum2(p[0], squares[0], p[1], squares[1]), p[2], squares[2])
    second = sum2(p[3], squares[1], p[4], squares[2])
    whole = plus22((none, none, none, none, none), first, squares[0])
    return plus22(whole, second, squares[2])
