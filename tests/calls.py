"""Every public function of arrays with the axes of its arguments and of what it returns."""

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

from tunneller_lib.paths import (
    ChordLaw,
    ConeChord,
    corrected_chord,
    project_chord,
    projected_length,
)
from tunneller_lib.paths.circuit import Circuit
from tunneller_lib.removal.arm_clearance import rod_clearance
from tunneller_lib.removal.volume import (
    advance_for_volume,
    bowl,
    groove_area,
    half_lens,
    removed_volume,
    ring,
)
from tunneller_lib.surfaces import (
    REFERENCE_MACHINE,
    Box,
    Cone,
    Cutter,
    Egg,
    Frustum,
    Rod,
    RoundedDisc,
    Torus,
)
from tunneller_lib.surfaces.box import meet_boxes
from tunneller_lib.surfaces.facet import meet_facets
from tunneller_lib.surfaces.frustum import meet_frusta
from tunneller_lib.surfaces.rod import meet_rods
from tunneller_lib.surfaces.rounded_disc import meet_rounded_discs


class Call(NamedTuple):
    """A public function of arrays: names and last axes of its arguments, last axes it returns.

    `flat` marks one that takes a single axis of values that belong together.
    """

    function: Callable
    names: tuple
    axes: tuple
    answer: tuple
    flat: bool = False


_TORUS, _EGG, _CONE, _CHORD = Torus(1, 2), Egg(0.5), Cone(0.5), ConeChord(1, 1, 0.5, 0.25)
_ROUNDED = RoundedDisc((0.1, 0.2, 0.3), (1, 2, 2), 0.5, 0.2)
_ROD, _ROUND = Rod((0, 0, 0), (0.5, 0.4, 0.3), 0.2), Rod((0, 0, 0), (0.5, 0.4, 0.3), 0.2, "round")
_EDGES = (0.4, 0.3, 0), (-0.3, 0.4, 0), (0, 0, 0.2)
_BOX = Box((0.1, 0, 0), *_EDGES)
_FRUSTUM = Frustum((0, 0, 0), (0.5, 0.4, 0.3), 0.3, 0.1)
_ALIGNED = Circuit(REFERENCE_MACHINE, _EGG)
_TILTED = Circuit(REFERENCE_MACHINE, _EGG, 0.01, 0.02)
_LINE = ("point", "direction"), ((3,), (3,)), ((), ())
_ANGLES, _JOINT, _POINT = (("theta", "phi"), ((), ())), ((2,),), ((3,),)

CALLS = {
    "Torus.point": Call(_TORUS.point, *_ANGLES, ((3,),)),
    "Torus.angles": Call(_TORUS.angles, ("point",), _POINT, ((), ())),
    "Torus.implicit": Call(_TORUS.implicit, ("point",), _POINT, ((),)),
    "Torus.normal": Call(_TORUS.normal, *_ANGLES, ((3,),)),
    "Torus.curvatures": Call(_TORUS.curvatures, *_ANGLES, ((), ())),
    "Torus.feet": Call(_TORUS.feet, ("m",), _POINT, ((4, 3),)),
    "Torus.foot": Call(_TORUS.foot, ("m",), _POINT, ((3,),)),
    "Torus.meet_line": Call(_TORUS.meet_line, ("a", "b"), ((3,), (3,)), ((4,),)),
    "Egg.point": Call(_EGG.point, ("s",), ((),), ((2,),)),
    "Egg.normal": Call(_EGG.normal, ("s",), ((),), ((2,),)),
    "Egg.depth": Call(_EGG.depth, ("y", "z"), ((), ()), ((),)),
    "Cone.implicit": Call(_CONE.implicit, ("point",), _POINT, ((),)),
    "Cone.point": Call(_CONE.point, ("distance", "azimuth"), ((), ()), ((3,),)),
    "Cone.feet": Call(_CONE.feet, ("m",), _POINT, ((2, 3),)),
    "Cone.development": Call(_CONE.development, ("distance", "azimuth"), ((), ()), ((2,),)),
    "Rod.contains": Call(_ROD.contains, ("points",), _POINT, ((),)),
    "Rod.contains round": Call(_ROUND.contains, ("points",), _POINT, ((),)),
    "Rod.meet_line": Call(_ROD.meet_line, *_LINE),
    "Rod.meet_line round": Call(_ROUND.meet_line, *_LINE),
    "Rod.meet_line parallel": Call(
        lambda point: _ROD.meet_line(point, (0.1, 0.2, 0.9)), ("point",), _POINT, ((), ())
    ),
    "meet_rods": Call(
        meet_rods, ("a", "b", "radius", "point", "direction"), ((3,), (3,), (), (3,), (3,)),
        ((), ()),
    ),
    "meet_frusta": Call(
        meet_frusta, ("a", "b", "radius_a", "radius_b", "point", "direction"),
        ((3,), (3,), (), (), (3,), (3,)), ((), ()),
    ),
    "meet_rounded_discs": Call(
        meet_rounded_discs, ("centre", "axis", "radius", "corner", "point", "direction"),
        ((3,), (3,), (), (), (3,), (3,)), ((), ()),
    ),
    "meet_facets": Call(
        partial(meet_facets, _ROD), ("facets", "direction"), ((3, 3), (3,)), ((), ()),
    ),
    "RoundedDisc.meet_line": Call(_ROUNDED.meet_line, *_LINE),
    "RoundedDisc.contains": Call(_ROUNDED.contains, ("points",), _POINT, ((),)),
    "meet_boxes": Call(
        lambda corner, point, direction: meet_boxes(corner, *_EDGES, point, direction),
        ("corner", "point", "direction"), ((3,), (3,), (3,)), ((), ()),
    ),
    "Box.meet_line": Call(_BOX.meet_line, *_LINE),
    "Cutter.meet_line": Call(Cutter.cone(0.2, 0.5, 2).meet_line, *_LINE),
    "Frustum.contains": Call(_FRUSTUM.contains, ("points",), _POINT, ((),)),
    "Frustum.meet_line": Call(_FRUSTUM.meet_line, *_LINE),
    "half_lens": Call(partial(half_lens, 5), ("advance",), ((),), ((),)),
    "bowl": Call(partial(bowl, 5), ("advance",), ((),), ((),)),
    "ring": Call(partial(ring, 5), ("advance",), ((),), ((),)),
    "groove_area": Call(partial(groove_area, 5), ("depth",), ((),), ((),)),
    "removed_volume": Call(
        lambda advance, depth: removed_volume(5, advance, depth, wall=20, pitch=0.1),
        ("advance", "depth"), ((), ()), ((),),
    ),
    "advance_for_volume": Call(
        partial(advance_for_volume, 5), ("volume", "depth"), ((), ()), ((),)
    ),
    "rod_clearance": Call(
        partial(rod_clearance, _EGG), ("a", "b", "radius"), ((3,), (3,), ()), ((),)
    ),
    "Circuit.arm": Call(_TILTED.arm, ("position",), _JOINT, ((3,), (3,))),
    "Circuit.arm_axes": Call(_TILTED.arm_axes, ("position",), _JOINT, ((3, 3),)),
    "Machine.within_limits": Call(REFERENCE_MACHINE.within_limits, ("position",), _JOINT, ((),)),
    **{
        f"project_chord {spacing}": Call(
            lambda p, q, spacing=spacing: project_chord(_TORUS, p, q, 4, spacing=spacing),
            ("p", "q"), ((2,), (2,)), ((4, 2),),
        )
        for spacing in ("chord", "tangent", "arc")
    },
    "corrected_chord": Call(
        lambda p, q: corrected_chord(_TORUS, p, q, 4), ("p", "q"), ((2,), (2,)), ((4, 2),)
    ),
    "ChordLaw.excess": Call(
        lambda p, q: ChordLaw(p, q).excess, ("p", "q"), ((2,), (2,)), ((),)
    ),
    "projected_length": Call(partial(projected_length, _TORUS), ("p", "q"), ((2,), (2,)), ((),)),
    "ConeChord.geodesic": Call(_CHORD.geodesic, ("u",), ((),), ((2,),)),
    "ConeChord.azimuth": Call(_CHORD.azimuth, ("u",), ((),), ((),)),
    "ConeChord.chord_point": Call(_CHORD.chord_point, ("azimuth",), ((),), ((3,),)),
    "ConeChord.tangent_sphere": Call(_CHORD.tangent_sphere, ("azimuth",), ((),), ((),)),
    "ConeChord.table": Call(_CHORD.table, ("u",), ((),), ((5,),)),
    "ConeChord.path": Call(_CHORD.path, ("u",), ((),), ((2,),)),
    "ConeChord.deviation": Call(_CHORD.deviation, ("u",), ((),), ((),)),
    "Circuit.position": Call(_ALIGNED.position, ("s",), ((),), ((2,),)),
    "Circuit.position tilted": Call(_TILTED.position, ("s",), ((),), ((2,),)),
    "Circuit.point": Call(_TILTED.point, ("s",), ((),), ((3,),)),
    "Circuit.in_tunnel": Call(_TILTED.in_tunnel, ("point",), _POINT, ((3,),)),
    "Circuit.overbreak": Call(_TILTED.overbreak, ("position",), _JOINT, ((),)),
    "Circuit.path_overbreak": Call(_ALIGNED.path_overbreak, ("s",), ((),), ((33,),), flat=True),
}  # fmt: skip
