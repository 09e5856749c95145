"""Abstract, sections 1 to 3 and the appendix' introduction: what they say in words and pictures.

One proof a claim; the verdicts stand in report/ledger/tunneller.toml.
"""

import re
from math import atan2, sqrt

import numpy as np
import sympy as sp

from tests import matlab_listing
from tests.basic_listing import PRINTED, REPAIRS, run
from tests.symbols_tunneller import R, phi, r, theta
from tunneller_lib.paths import (
    ConeChord,
    competing_geodesics,
    cutting_circuit,
    geodesic_direct,
    geodesic_inverse,
    project_chord,
)
from tunneller_lib.reporting.machine_scene import BODY, machine_model
from tunneller_lib.surfaces import REFERENCE_MACHINE, Cone, Egg, Torus

MACHINE, EGG = REFERENCE_MACHINE, Egg(0.5)


def test_geodesic_isn_t_always_shortest():
    # The outer equator is a geodesic. Along it neighbours meet again after pi/sqrt(K), where
    # K = 1/(R (r + R)): before the half turn, from where on it isn't the shortest way.
    K = sp.cos(phi) / (R * (r + R * sp.cos(phi)))
    conjugate = sp.pi / sp.sqrt(K.subs(phi, 0))
    half_turn = sp.pi * (r + R)
    assert sp.simplify(half_turn**2 - conjugate**2 - sp.pi**2 * r * (r + R)) == 0  # > 0
    ring = Torus(3, 1)
    turn = 0.9 * np.pi
    equator = geodesic_direct(ring, (0, 0), np.pi / 2, 4 * turn)
    np.testing.assert_allclose(equator.position[-1], [turn, 0], atol=1e-12)
    ways = competing_geodesics(ring, (0, 0), (turn, 0))
    lengths = ways.length[ways.converged]
    assert np.min(np.abs(lengths - 4 * turn)) < 1e-12  # among those that lead there
    assert lengths[0] < 4 * turn - 0.5
    # Short ones are the shortest: half as far as neighbours meet.
    near = float(conjugate.subs({r: 3, R: 1})) / 2 / 4
    assert abs(geodesic_inverse(ring, (0, 0), (near, 0)).length - 4 * near) < 1e-12


def test_figure_one():
    # The substitute's parts sit where the text puts the joints and the cutter.
    for pose in np.radians([(0, 0), (-50, 30), (30, -40)]):
        centre = MACHINE.torus.point(*pose)
        hinge = MACHINE.r * np.array([np.cos(pose[0]), 0, -np.sin(pose[0])])
        meshes = [mesh for mesh, _ in machine_model(MACHINE, *pose)]
        middles = np.array([mesh.center for mesh in meshes])
        balls = [m for m in meshes if np.ptp(np.linalg.norm(m.points - centre, axis=1)) < 1e-6]
        assert len(balls) == 1 and balls[0].n_points > 1000
        assert np.min(np.linalg.norm(middles, axis=1)) < 1e-9  # the horizontal joint's pin
        assert np.min(np.linalg.norm(middles - hinge, axis=1)) < 1e-7  # the tangential joint's
        assert abs(np.linalg.norm(centre - hinge) - MACHINE.R) < 1e-12
    assert any(look is BODY for _, look in machine_model(MACHINE, 0.0, 0.0))


def test_offset_circuit():
    # On the torus, closed, and the ball's farthest point is the depth of cut beyond the wall.
    circuit = cutting_circuit(MACHINE, EGG)
    s = np.linspace(0, circuit.profile.perimeter, 401)
    centres = circuit.point(s)
    assert np.max(np.abs(MACHINE.torus.implicit(centres))) < 1e-13
    np.testing.assert_allclose(centres[0], centres[-1], atol=1e-12)
    in_tunnel = circuit.in_tunnel(centres)
    inside = EGG.depth(in_tunnel[:, 1], in_tunnel[:, 2])
    np.testing.assert_allclose(MACHINE.cutter_radius - inside, MACHINE.depth, atol=1e-12)
    out = np.linspace(0, 2 * np.pi, 721)
    for _, y, z in in_tunnel[::40]:
        rim = np.array([y, z]) + MACHINE.cutter_radius * np.stack([np.cos(out), np.sin(out)], -1)
        beyond = -np.min(EGG.depth(*rim.T))
        assert abs(beyond - MACHINE.depth) < 1e-4 * MACHINE.cutter_radius


def test_meridian_circles():
    # For fixed theta: a circle of radius R in a plane that holds the y axis, the torus' own.
    point = sp.Matrix([(r + R * sp.cos(phi)) * sp.cos(theta), R * sp.sin(phi),
                       -(r + R * sp.cos(phi)) * sp.sin(theta)])  # fmt: skip
    plane = sp.Matrix([sp.sin(theta), 0, sp.cos(theta)])
    assert sp.simplify(plane.dot(point)) == 0 and plane[1] == 0
    torus, phis = MACHINE.torus, np.linspace(-0.7, 0.7, 9)
    for angle in (-1.0, 0.0, 0.6):
        circle = torus.point(angle, phis)
        assert np.max(np.abs(circle @ [np.sin(angle), 0, np.cos(angle)])) < 1e-15
        hub = torus.r * np.array([np.cos(angle), 0, -np.sin(angle)])
        np.testing.assert_allclose(np.linalg.norm(circle - hub, axis=-1), torus.R, rtol=1e-15)


def test_figure_five():
    # The part of the torus that the joints sweep closes the whole offset section.
    circuit = cutting_circuit(MACHINE, EGG)
    s = np.linspace(0, circuit.profile.perimeter, 2001)
    assert MACHINE.within_limits(circuit.position(s)).all()
    corners = MACHINE.torus.point([MACHINE.theta_min, MACHINE.theta_max], 0.0)
    corners = circuit.in_tunnel(corners)
    assert np.all(circuit.profile.depth(corners[:, 1], corners[:, 2]) < 0)  # and reaches beyond
    sides = circuit.in_tunnel(MACHINE.torus.point(0.0, [MACHINE.phi_min, MACHINE.phi_max]))
    assert np.all(circuit.profile.depth(sides[:, 1], sides[:, 2]) < 0)


def test_wanted_path_is_no_geodesic():
    # The wall asks for the circuit. On it rho sin(azimuth) isn't constant, as on a geodesic, and
    # the geodesic between two of its points a quarter round passes far from it.
    circuit = cutting_circuit(MACHINE, EGG)
    whole = circuit.profile.perimeter
    s, step = np.linspace(0, whole / 4, 201), 1e-6
    move = (circuit.point(s + step) - circuit.point(s - step)) / 2
    angle, swing = circuit.position(s).T
    around = np.stack([-np.sin(angle), np.zeros_like(angle), -np.cos(angle)], axis=-1)
    share = np.sum(move * around, axis=-1) / np.linalg.norm(move, axis=-1)
    clairaut = (MACHINE.r + MACHINE.R * np.cos(swing)) * share
    assert np.ptp(clairaut) > 0.5 * MACHINE.R
    ends = circuit.position([0.0, whole / 4])
    geodesic = geodesic_inverse(MACHINE.torus, *ends)
    away = np.abs(geodesic.points(65).deviation(circuit.position(s)))
    assert np.max(away) > 5 * MACHINE.depth
    length = np.sum(np.linalg.norm(np.diff(circuit.point(s), axis=0), axis=-1))
    assert length > 1.01 * geodesic.length


def test_geodesics_leave_in_every_direction():
    # One for each azimuth, and no two with the same first step: a family of one parameter.
    torus, azimuths = MACHINE.torus, np.linspace(-np.pi, np.pi, 73)[:-1]
    ways = geodesic_direct(torus, (0.1, 0.2), azimuths, 0.05, 51)
    first = ways.tangent[:, 0]
    np.testing.assert_allclose(np.linalg.norm(first, axis=-1), 1, rtol=1e-12)
    assert np.max(np.abs(first @ torus.normal(0.1, 0.2))) < 1e-12
    np.testing.assert_allclose(np.sum(first * np.roll(first, 1, axis=0), axis=-1),
                               np.cos(np.radians(5)), rtol=1e-12)  # fmt: skip
    # A shortest way bends towards the normal alone.
    bend = np.gradient(ways.tangent, 0.001, axis=1)[:, 2:-2]
    normal = torus.normal(*np.moveaxis(ways.position, -1, 0))[:, 2:-2]
    aside = bend - np.sum(bend * normal, axis=-1, keepdims=True) * normal
    assert np.max(np.abs(aside)) < 1e-5 * np.max(np.abs(bend))


def test_cone_is_developable():
    # Curvature zero; and the straight line of the development keeps Clairaut's rho sin(azimuth).
    alpha, d = sp.symbols("alpha d", positive=True)
    point = d * sp.Matrix([sp.sin(alpha) * sp.cos(theta), sp.sin(alpha) * sp.sin(theta),
                           -sp.cos(alpha)])  # fmt: skip
    along, around = point.diff(d), point.diff(theta)
    normal = along.cross(around)
    form = [sp.simplify(second.dot(normal)) for second in
            (point.diff(d, 2), point.diff(d, theta), point.diff(theta, 2))]  # fmt: skip
    assert sp.simplify(form[0] * form[2] - form[1] ** 2) == 0
    for values in ((1, 1, 0.5, 0.25), (3, 4, 1, 0.3)):
        chord, u = ConeChord(*values), np.linspace(0.01, 0.99, 99)
        here, step = chord.geodesic(u), 1e-6
        angle = np.arctan2(here[:, 1], here[:, 0])
        turn = (chord.azimuth(u + step) - chord.azimuth(u - step)) / (2 * step)
        rho = np.linalg.norm(here, axis=-1) * np.sin(chord.cone.half_angle)
        clairaut = rho**2 * turn / chord.geodesic_length
        np.testing.assert_allclose(clairaut, clairaut[0], rtol=1e-7)
        np.testing.assert_allclose(chord.azimuth(u) * np.sin(chord.cone.half_angle), angle)


def test_example_centre():
    # M in decimals, with k = 1/4, a half-angle of arctan(1/2).
    M = [-sp.sqrt(2), -3 * sp.sqrt(2), -12]
    printed = (-1.414213562, -4.242640687, -12)
    assert max(abs(float(exact - shown)) for exact, shown in zip(M, printed, strict=True)) < 5e-10
    cone = Cone(np.arctan(0.5))
    assert abs(cone.k - 0.25) < 1e-15 and cone.implicit(np.array(printed)) < 0  # inside


def test_homogeneous_coordinates():
    # P and the plane for every fraction f; Q only for a quarter turn.
    P, plane = sp.Matrix([1, R, 0, 0]), sp.Matrix([0, -sp.sin(theta), sp.cos(theta), 0])
    assert sp.simplify(plane[1:, 0].dot(sp.Matrix([sp.cos(theta), sp.sin(theta), 7]))) == 0
    assert plane.subs(theta, 0).dot(P) == 0  # P's own plane
    for f, right in ((0.25, True), (0.3, False)):
        radius, height, h = 2, 1, 0.5
        chord = ConeChord(radius, height, h, f)
        ends = chord.chord_point([0.0, chord.turn])
        np.testing.assert_allclose(ends[0], (radius, 0, -height), atol=1e-12)
        assert np.allclose(ends[1], (0, h * radius / height, -h)) is right
    p, q = sp.Matrix(sp.symbols("p0:4")), sp.Matrix(sp.symbols("q0:4"))
    lines = {(i, j): p[i] * q[j] - p[j] * q[i] for i in range(4) for j in range(4)}
    assert all(sp.expand(lines[i, j] + lines[j, i]) == 0 for i, j in lines)  # and m_ii = 0
    pluecker = lines[0, 1] * lines[2, 3] + lines[0, 2] * lines[3, 1] + lines[0, 3] * lines[1, 2]
    assert sp.expand(pluecker) == 0  # the six are a line's


def test_listing_pi():
    # Ten digits are enough for a table of four.
    assert "PI=3.141592654" in PRINTED[100]
    assert abs(3.141592654 - sp.pi.evalf(20)) < 5e-10
    printed = np.array(run(1, 1, 0.5, 0.25, 10, repaired=list(REPAIRS)))
    table = ConeChord(1, 1, 0.5, 0.25).table(np.arange(11) / 10)
    table[:, 1] = np.degrees(table[:, 1])
    assert 0 < np.max(np.abs(printed - table)) < 1e-7


def test_efficient_implementation():
    # Neither of the document's programs moves on a torus, and neither takes a time or a count.
    basic, matlab = " ".join(PRINTED.values()), matlab_listing.PRINTED
    assert set(re.findall(r"[A-Z]+(?=\()", basic)) <= {"SQR", "COS", "SIN", "ATN", "TAN"}
    assert PRINTED[240] == "LPRINT U,180*PHI/PI, LN, NN, NN-LN"  # all that it prints a step
    assert not re.search(r"\b(sin|cos|atan2?|sqrt|tic|toc|clock|cputime)\b", matlab)
    # What the first one computes, mended, is the path on its cone.
    for row in run(3, 4, 1, 0.2, 10, repaired=list(REPAIRS)):
        chord = ConeChord(3, 4, 1, 0.2)
        assert np.isclose(row[2], chord.table(row[0])[2], rtol=1e-9)
    # Ours for a torus: a chord's point by three sums, then a root and two arctangents.
    ends = (-0.3, 0.2), (0.4, -0.3)
    (x1, y1, z1), q = (MACHINE.torus.point(*end).tolist() for end in ends)
    dx, dy, dz = ((far - near) / 10 for far, near in zip(q, (x1, y1, z1), strict=True))
    for expected in project_chord(MACHINE.torus, *ends, 11):
        found = atan2(-z1, x1), atan2(y1, sqrt(x1 * x1 + z1 * z1) - MACHINE.r)
        np.testing.assert_allclose(found, expected, atol=1e-12)
        x1, y1, z1 = x1 + dx, y1 + dy, z1 + dz
