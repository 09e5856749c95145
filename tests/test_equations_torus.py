"""Tunnelling robot, sections 1 and 3.1: the machine's torus, Eqs 1 to 3, Figs 2 and 3.

`printed` is always the form that the document prints. Where it is wrong, a counterexample shows
it, the corrected form is proved, and the library is held against what was proved. The verdicts
stand in report/ledger/tunneller.toml.
"""

import itertools

import numpy as np
import sympy as sp

from tests.shapes import PROOFS
from tests.symbols_tunneller import TORUS, R, at, close, draw, phi, r, theta, w, x, y, z, zero
from tunneller_lib.surfaces import REFERENCE_MACHINE, Torus

READS = ["report/ledger/*"]


def test_ring_radius_words(judge):
    point = sp.Matrix([(r + R * sp.cos(phi)) * sp.cos(theta), R * sp.sin(phi),
                       -(r + R * sp.cos(phi)) * sp.sin(theta)])  # fmt: skip

    def is_ring(radius):  # the tube's circle is equally far from its centre
        centre = radius * sp.Matrix([sp.cos(theta), 0, -sp.sin(theta)])
        return zero((point - centre).dot(point - centre).diff(phi))

    judge("ring-radius", is_ring(R), right=is_ring(r))  # "the greater, ring centre circle radius R"
    centre = r * sp.Matrix([sp.cos(theta), 0, -sp.sin(theta)])
    assert zero((point - centre).dot(point - centre) - R**2)
    # With r the lesser, the torus meets itself in two nodes on the joint's axis.
    node = {x: 0, y: sp.sqrt(R**2 - r**2), z: 0}
    assert zero([TORUS.subs(node), *[TORUS.diff(v).subs(node) for v in (x, y, z)]])
    # A second way, measured on the library's tori: distances from a circle of either radius.
    for torus in PROOFS:
        x_, y_, z_ = torus.point(*3 * draw(30, 2, 50)).T
        ring, printed = (np.hypot(np.hypot(x_, z_) - size, y_) for size in (torus.r, torus.R))
        inner = np.hypot(np.hypot(x_, z_) + torus.r, y_)  # of the sheet beyond the axis
        assert close(np.minimum(abs(ring - torus.R), abs(inner - torus.R)), 0, torus.R)
        assert np.ptp(printed) > 0.1 * torus.r
    assert close(Torus(1, 2).point(0.7, np.arccos(-1 / 2)), [0, 3**0.5, 0])  # a node


def test_joint_ranges(judge):
    limits = REFERENCE_MACHINE
    ranges = [(-40, 40), (-60, 35), (-60, 60)]

    def printed(low, angle, high):
        return low >= angle <= high

    def corrected(low, angle, high):
        return low <= angle <= high

    def are_ranges(allow):  # straight ahead is allowed, and backwards forbidden
        ahead = [allow(low, 0, high) for low, high in ranges]
        backwards = [allow(low, low - 90, high) for low, high in ranges]
        return all(ahead) and not any(backwards)

    judge("joint-ranges", are_ranges(printed), right=are_ranges(corrected))
    # A second way, poses: the printed relation admits some with the cutter behind the joints, the
    # corrected none.
    behind = limits.torus.point(0, np.radians(np.arange(-260, 41)))[:, 0] < limits.r
    assert np.any(behind[:221]) and not np.any(behind[220:])  # up to -40, and from there on


def test_ratio_eight_somewhat_less(judge):
    judge("ratio-8", missing="the sizes of the authors' machine")
    machine = sp.Rational(str(REFERENCE_MACHINE.R)) / sp.Rational(str(REFERENCE_MACHINE.r))
    shown = sp.Integer(8)
    ratio = sp.symbols("ratio", positive=True)
    # Half the spread of the distances from the centre, in radii R: it falls with R/r.
    spread = (1 + 1 / ratio - sp.sqrt(1 - 1 / ratio**2)) / 2
    # The reference machine, whose ratio is above 8, is nearer a sphere.
    assert spread.subs(ratio, machine) < spread.subs(ratio, shown)


def test_fig2_distances_diminish(judge):
    along_theta = sp.sqrt(sum(c.diff(theta) ** 2 for c in parametrised()))
    along_phi = sp.sqrt(sum(c.diff(phi) ** 2 for c in parametrised()))
    assert zero(along_theta**2 - (r + R * sp.cos(phi)) ** 2)  # falls as |phi| grows
    assert zero((r + R * sp.cos(phi)).diff(phi) + R * sp.sin(phi))
    assert zero(along_phi**2 - R**2)  # doesn't
    torus, step, phis = Torus(1, 8), np.radians(10), np.radians(np.arange(0, 61, 10))
    across = np.linalg.norm(torus.point(step, phis) - torus.point(0, phis), axis=-1)
    up = np.linalg.norm(np.diff(torus.point(0, phis), axis=0), axis=-1)

    def diminish(distances):
        return np.all(np.diff(distances) < -1e-9)

    judge("fig2", cases={"steps of theta": diminish(across), "steps of phi": diminish(up)})


def test_fig3_nearly_spherical(judge):
    distance2 = sum(c**2 for c in parametrised())
    assert zero(distance2.diff(phi) + 2 * r * R * sp.sin(phi))  # falls from equator to node
    equator, node = sp.simplify(distance2.subs(phi, 0)), distance2.subs(sp.cos(phi), -r / R)
    node = sp.simplify(node.subs(sp.sin(phi) ** 2, 1 - r**2 / R**2))
    assert zero([equator - (R + r) ** 2, node - (R**2 - r**2)])
    eight = {r: 1, R: 8}
    assert (sp.sqrt(equator.subs(eight)), sp.sqrt(node.subs(eight))) == (9, 3 * sp.sqrt(7))
    off = (9 - 3 * sp.sqrt(7)) / (9 + 3 * sp.sqrt(7))  # from the sphere half-way between
    judge("fig3", cases={"to a tenth": bool(off < sp.Rational(1, 10)),
                         "to a hundredth": bool(off < sp.Rational(1, 100))})  # fmt: skip
    assert sp.Rational(6, 100) < off < sp.Rational(7, 100)


def parametrised():
    """Return the right sides of Eq. 1 as printed."""
    return ((r + R * sp.cos(phi)) * sp.cos(theta), R * sp.sin(phi),
            -(r + R * sp.cos(phi)) * sp.sin(theta))  # fmt: skip


def horizontal_joint():
    """Return the turn by theta about y."""
    cos, sin = sp.cos(theta), sp.sin(theta)
    return sp.Matrix([[cos, 0, sin], [0, 1, 0], [-sin, 0, cos]])


def test_eq01_point(judge):
    printed = sp.Matrix(parametrised())
    swing = sp.Matrix([R * sp.cos(phi), R * sp.sin(phi), 0])  # tangential joint
    judge("eq01", zero(horizontal_joint() * (sp.Matrix([r, 0, 0]) + swing) - printed))


def test_frame(judge):
    forward, up = sp.Matrix([1, 0, 0]), sp.Matrix([0, 0, 1])
    left = up.cross(forward)
    assert left == sp.Matrix([0, 1, 0])  # +y is left, and x, y, z is right-handed
    turn = horizontal_joint()
    assert zero(turn.diff(theta).subs(theta, 0) * forward - left.cross(forward))
    level = sp.Matrix(parametrised()).subs(phi, 0)
    assert zero(turn * sp.Matrix([r + R, 0, 0]) - level)
    ahead = level.subs(theta, 0) == (r + R) * forward
    axis = turn * left == left
    lifted = level.subs(theta, -sp.pi / 3).dot(up)  # "-60 represents elevation"
    judge("frame", ahead and axis and bool(lifted.is_positive))


def test_eq01_cited_as_eq02(judge):
    # "Squaring Eqs. 2 and adding these": only the three lines of Eq. 1 can be squared and added.
    on_surface = dict(zip((x, y, z), parametrised(), strict=True))
    printed = [sp.simplify(TORUS.subs(on_surface))]  # Eq. 2, whose left side is zero already
    assert printed == [0]

    def squares_add_up(sides):
        return zero(sum(side**2 for side in sides) - (r**2 + 2 * r * R * sp.cos(phi) + R**2))

    judge("eq01-cited", squares_add_up(printed), right=squares_add_up(parametrised()))
    # A second way, in numbers: the sum is that of Eq. 1, while Eq. 2 says 0.
    point = Torus(1, 2).point(0.7, 0.4)
    assert close(np.sum(point**2), 1 + 4 * np.cos(0.4) + 4)
    assert close(Torus(1, 2).implicit(point), 0)


def test_eq02_implicit(judge):
    printed = TORUS
    holds = zero(printed.subs(dict(zip((x, y, z), parametrised(), strict=True))))
    # Nothing else: in rho^2 = x^2 + z^2 it is the product over both meridian circles.
    rho = sp.symbols("rho")
    circles = sp.prod((rho - s * r) ** 2 + y**2 - R**2 for s in (1, -1))
    judge("eq02", holds and zero(printed.subs({x: rho, z: 0}) - circles))


def test_eq02_derivation(judge):
    # x^2 + y^2 + z^2 = r^2 + 2 r R cos(phi) + R^2, cos(phi) from y = R sqrt(1 - cos^2(phi)).
    cosine, total = sp.symbols("cosine total")
    first = total - (r**2 + 2 * r * R * cosine + R**2)
    second = y**2 - R**2 * (1 - cosine**2)
    eliminated = sp.resultant(first, second, cosine) / R**2
    judge("eq02-derivation", zero(eliminated.subs(total, x**2 + y**2 + z**2) - TORUS))


def test_eq02_expansion(judge):
    c2, s2 = sp.cos(theta) ** 2, sp.sin(theta) ** 2
    printed = (r + R * sp.cos(phi)) ** 2 * (c2 + s2) + R**2 * sp.sin(theta) ** 2
    corrected = (r + R * sp.cos(phi)) ** 2 * (c2 + s2) + R**2 * sp.sin(phi) ** 2
    truth = sum(c**2 for c in parametrised())
    judge("eq02-expansion", zero(printed - truth), right=zero(corrected - truth))
    # The document's next line follows from the corrected one only.
    assert zero(corrected - (r**2 + 2 * r * R * sp.cos(phi) + R**2))
    # A second way, in numbers: the library's points, near and far.
    for torus in PROOFS:
        angles = draw(31, 2, 50)
        truth = np.sum(torus.point(*angles) ** 2, axis=-1) / torus.R**2
        values = (torus.r, torus.R, *angles)
        assert close(at(corrected, (r, R, theta, phi), values) / torus.R**2, truth)
        assert np.max(np.abs(at(printed, (r, R, theta, phi), values) / torus.R**2 - truth)) > 0.1


def test_eq03_homogeneous(judge):
    rho = sp.symbols("rho")
    sphere = -(rho**2) * w**2 + x**2 + y**2 + z**2
    powers = [p for p in itertools.product(range(4), repeat=4) if sum(p) == 3]
    coefficients = [sp.Symbol("k_{}{}{}{}".format(*p)) for p in powers]
    monomials = [sp.prod(map(sp.Pow, (w, x, y, z), p)) for p in powers]
    cubic = sum(c * monomial for c, monomial in zip(coefficients, monomials, strict=True))
    printed, corrected = sphere**2 + cubic, sphere**2 + w * cubic
    assert sp.Poly(corrected, w, x, y, z).is_homogeneous
    judge("eq03", cases={"w = 1": zero((printed - corrected).subs(w, 1)),
                         "any w": sp.Poly(printed, w, x, y, z).is_homogeneous})  # fmt: skip


def test_eq03_cyclide(judge):
    # A cyclide has the circle at infinity, w = 0 and x^2 + y^2 + z^2 = 0, as a double curve.
    sphere = x**2 + y**2 + z**2
    constants = sp.symbols("c0:20")
    quadric = sp.Matrix([w, x, y, z]).dot(sp.Matrix(4, 4, lambda i, j: constants[4 + 4 * i + j])
                                          * sp.Matrix([w, x, y, z]))  # fmt: skip
    linear = sum(c * v for c, v in zip(constants[:4], (w, x, y, z), strict=True))

    def is_cyclide(surface):
        ideal = [surface.diff(v).subs(w, 0) for v in (w, x, y, z)]
        return all(zero(sp.rem(sp.expand(g), sphere, x)) for g in ideal)

    judge("eq03-cyclide",
          cases={"(x^2 + y^2 + z^2) times a linear form":
                 is_cyclide(sphere**2 + w * sphere * linear + w**2 * quadric),
                 "the cubic x^3": is_cyclide(sphere**2 + w * x**3)})  # fmt: skip
    # The torus itself has no cubic part, so it is among Eq. 3's.
    assert all(sum(powers) != 3 for powers, _ in sp.Poly(TORUS, x, y, z).terms())
