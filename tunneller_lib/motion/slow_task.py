"""The slow task for a controller that gets its knots as it goes: waypoints of a corrected chord.

That of a job (`tunneller_lib.job`) has a table of where on each chord its setpoints are.
"""

from importlib.resources import files

from ..arguments import Whole, checked
from .export import C_HEAD, c99_code, c99_types, operations, read_blocks

LEAST, MOST = 3, 1_000  # waypoints of a segment


@checked
def waypoints_text(points: Whole(LEAST, MOST)):
    """Return the slow task's waypoints as a function block in Structured Text (IEC 61131-3).

    Parameters
    ----------
    points : int
        Waypoints of a segment, both ends included.

    Returns
    -------
    text : str
        A call with the sizes of the torus, r as ring and R as tube, and the ends' joint positions,
        in m and rad, fills theta and phi, in rad. It needs LREAL, and ATAN2 of the standard's
        third edition.

    Notes
    -----
    The corrected chord of `tunneller_lib.paths`, without iteration; the swing of the geodesic
    comes from Numerov's method on the waypoints themselves. From 5 waypoints on the angles agree
    with the library's to a tenth of a count of 2^16 a turn, on the reference machine's torus
    within its joint limits; the difference falls with the fourth power of their number.
    """
    text = files(__package__).joinpath("waypoints.st").read_text(encoding="utf-8")
    return text.replace("@LAST", str(points - 1))


@checked
def waypoints_c99(points: Whole(LEAST, MOST)):
    """Return the same block for so many `points` in C99."""
    blocks = read_blocks(waypoints_text(points))
    return "\n".join([C_HEAD, c99_types(blocks), c99_code(blocks)])


@checked
def waypoint_operations(points: Whole(LEAST, MOST)):
    """Return the `Operations` of the block for so many `points`, correction and all."""
    (block,) = read_blocks(waypoints_text(points))
    return operations(block)
