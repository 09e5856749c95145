"""How the joints move the cutter's centre out of the wall."""

import numpy as np

from ..kernels.exact import dot


def wall_frame(circuit, s):
    """Return normals and tangents (..., 3) and curvatures (...) of the offset section at s.

    s are arc lengths in m; directions are in the machine's frame, curvatures 1/rho in 1/m.
    """
    normal = circuit.profile.normal(s)
    tangent = np.stack([-normal[..., 1], normal[..., 0]], axis=-1)
    axes = circuit.axes[1:]
    return normal @ axes, tangent @ axes, circuit.profile.curvature(s)


def gradient(circuit, s, q):
    """Return df/dq (..., 2) at joint positions q (..., 2) with f = 0 at places s, in m/rad."""
    normal, _, _ = wall_frame(circuit, s)
    moves = circuit.machine.torus.velocity(q[..., None, :], np.eye(2))
    return dot(moves, normal[..., None, :])
