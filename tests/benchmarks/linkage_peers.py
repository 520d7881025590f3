"""The four-bar and the six-bar of the kinematics benchmark, as linkframe, pylinkage and exudyn take them.

All begin with the crank at zero and turn it by `angles`. Each way is a function that goes through the whole sweep and
returns the places (poses, 2) of all moving pins by name.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from linkframe.models import Linkage
from numpy.typing import NDArray

from .harness import importable

Array = NDArray[np.float64]
Pins = dict[str, Array]
Way = Callable[[], Pins]

GROUND = {"A": 0j, "E": 0.22 + 0j, "G": 0.5 + 0j}
# Link by link: points, the first two of which are its line; lengths from there.
FOUR_BAR = {"crank": "AB", "coupler": "BD", "rocker": "ED"}
SIX_BAR = {"crank": "AB", "coupler": "BDP", "rocker": "ED", "rod": "PF", "arm": "GF"}
LINKAGES = {"four-bar": FOUR_BAR, "six-bar": SIX_BAR}


def pin(first: complex, second: complex, a: float, b: float) -> complex:
    """Place at the distance a from `first` and b from `second`, on the left of the line between."""
    chord = second - first
    along = (abs(chord) ** 2 + a**2 - b**2) / (2.0 * abs(chord))
    return complex(first + (along + 1j * np.sqrt(a**2 - along**2)) * chord / abs(chord))


def drawing() -> dict[str, complex]:
    """Places of all pins with the crank at zero."""
    b = 0.1 + 0j
    d = pin(b, GROUND["E"], 0.25, 0.2)
    p = b + (0.6 + 0.5j) * (d - b)
    return {**GROUND, "B": b, "D": d, "P": p, "F": pin(p, GROUND["G"], 0.4, 0.3)}


AT = drawing()


def closure_error(links: Mapping[str, str], pins: Pins) -> float:
    """Greatest change of a distance between pins of one link, over the size of the linkage."""
    count = len(pins["B"])
    places = {name: np.broadcast_to([z.real, z.imag], (count, 2)) for name, z in AT.items()} | pins
    worst = 0.0
    for points in links.values():
        for k, one in enumerate(points):
            for other in points[:k]:
                length = np.linalg.norm(places[one] - places[other], axis=-1)
                worst = max(worst, float(np.abs(length - abs(AT[one] - AT[other])).max()))
    return worst / max(abs(z) for z in AT.values())


# -- linkframe --------------------------------------------------------------------------------------------------------


def described(links: Mapping[str, str], drive: str = "A") -> Linkage:
    """The linkage in linkframe."""
    used = sorted({point for points in links.values() for point in points})
    linkage = Linkage({name: (AT[name].real, AT[name].imag) for name in used})
    for name, points in links.items():
        linkage.link(name, *points)
    for point in used:
        on = [name for name, points in links.items() if point in points]
        linkage.revolute(point, *(["ground"] if point in GROUND else []), *on, drive=point == drive)
    return linkage


def linkframe(links: Mapping[str, str], angles: Array) -> Way:
    """Sweep of a linkage that was described before."""
    linkage = described(links)
    moving = [name for name in linkage.points if name not in GROUND]

    def sweep() -> Pins:
        motion = linkage.move(A=angles)
        return {name: motion.position(name)[:, :2] for name in moving}

    return sweep


def linkframe_anew(links: Mapping[str, str], angles: Array) -> Way:
    """Description, compilation and sweep."""
    return lambda: linkframe(links, angles)()


# -- pylinkage --------------------------------------------------------------------------------------------------------


def _pylinkage(links: Mapping[str, str], angles: Array) -> tuple[Any, dict[str, int]]:
    from pylinkage.actuators import Crank
    from pylinkage.components import Ground
    from pylinkage.dyads import FixedDyad, RRRDyad
    from pylinkage.simulation import Linkage as Simulated

    a, e, g = (Ground(GROUND[name].real, GROUND[name].imag, name=name) for name in "AEG")
    crank = Crank(anchor=a, radius=0.1, angular_velocity=float(angles[1] - angles[0]))
    d = RRRDyad(anchor1=crank.output, anchor2=e, distance1=0.25, distance2=0.2)
    parts, columns = [a, e, crank, d], {"B": 2, "D": 3}
    if "rod" in links:
        arm = (AT["P"] - AT["B"]) / (AT["D"] - AT["B"])
        p = FixedDyad(anchor1=crank.output, anchor2=d, distance=0.25 * abs(arm), angle=float(np.angle(arm)))
        f = RRRDyad(anchor1=p, anchor2=g, distance1=0.4, distance2=0.3)
        parts, columns = [a, e, g, crank, d, p, f], {"B": 3, "D": 4, "P": 5, "F": 6}
    return Simulated(parts), columns


def pylinkage_steps(links: Mapping[str, str], angles: Array) -> Way:
    """Its interpreted way, `step`."""
    linkage, columns = _pylinkage(links, angles)
    start = linkage.get_coords()

    def sweep() -> Pins:
        linkage.set_coords(start)
        found = np.array(list(linkage.step(len(angles))))
        return {name: found[:, k] for name, k in columns.items()}

    return sweep


def pylinkage_fast(links: Mapping[str, str], angles: Array) -> Way:
    """Its way compiled by numba, `step_fast`."""
    linkage, columns = _pylinkage(links, angles)
    start = linkage.get_coords()

    def sweep() -> Pins:
        linkage.set_coords(start)
        found = linkage.step_fast(len(angles))
        return {name: found[:, k] for name, k in columns.items()}

    return sweep


# -- exudyn -----------------------------------------------------------------------------------------------------------


def exudyn(links: Mapping[str, str], angles: Array) -> Way:
    """Rigid bodies with joints as constraints; its static solver, the crank's angle a function of the load step."""
    import exudyn as exu
    from exudyn import itemInterface as items

    system = exu.SystemContainer().AddSystem()
    world = system.AddObject(items.ObjectGround())
    step = float(angles[1] - angles[0])
    markers: dict[str, list[int]] = {}
    sensors: dict[str, int] = {}
    for name, z in GROUND.items():
        if any(name in points for points in links.values()):
            place = [z.real, z.imag, 0.0]
            markers[name] = [system.AddMarker(items.MarkerBodyRigid(bodyNumber=world, localPosition=place))]
    nodes = {}
    for link, points in links.items():
        start, along = AT[points[0]], AT[points[1]] - AT[points[0]]
        turn = along / abs(along)
        pose = [start.real, start.imag, float(np.angle(along))]
        nodes[link] = system.AddNode(items.NodeRigidBody2D(referenceCoordinates=pose))
        body = system.AddObject(items.RigidBody2D(mass=1.0, inertia=1.0, nodeNumber=nodes[link]))
        for point in points:
            arm = (AT[point] - start) / turn
            place = [arm.real, arm.imag, 0.0]
            markers.setdefault(point, []).append(
                system.AddMarker(items.MarkerBodyRigid(bodyNumber=body, localPosition=place))
            )
            if point not in GROUND and point not in sensors:
                sensors[point] = system.AddSensor(
                    items.SensorBody(
                        bodyNumber=body,
                        localPosition=place,
                        storeInternal=True,
                        outputVariableType=exu.OutputVariableType.Position,
                    )
                )
    for first, *others in markers.values():
        for other in others:
            system.AddObject(items.RevoluteJoint2D(markerNumbers=[first, other]))
    fixed = system.AddMarker(
        items.MarkerNodeCoordinate(nodeNumber=system.AddNode(items.NodePointGround()), coordinate=0)
    )
    angle = system.AddMarker(items.MarkerNodeCoordinate(nodeNumber=nodes["crank"], coordinate=2))
    whole = step * len(angles)
    system.AddObject(
        items.CoordinateConstraint(
            markerNumbers=[fixed, angle], offsetUserFunction=lambda _system, time, _number, _offset: whole * time
        )
    )
    system.Assemble()
    settings = exu.SimulationSettings()
    settings.staticSolver.numberOfLoadSteps = len(angles)
    settings.staticSolver.verboseMode = 0
    settings.staticSolver.newton.relativeTolerance = settings.staticSolver.newton.absoluteTolerance = 1e-12
    settings.solution.file.write = False
    settings.solution.sensors.writePeriod = 1.0 / len(angles)

    def sweep() -> Pins:
        system.SolveStatic(settings, updateInitialValues=False)
        return {name: system.GetSensorStoredData(sensor)[-len(angles) :, 1:3] for name, sensor in sensors.items()}

    return sweep


def ways() -> dict[str, Callable[[Mapping[str, str], Array], Way]]:
    """All contenders that are installed."""
    found: dict[str, Callable[[Mapping[str, str], Array], Way]] = {
        "linkframe": linkframe,
        "linkframe, description anew": linkframe_anew,
    }
    if importable("pylinkage"):
        found["pylinkage step"] = pylinkage_steps
        if importable("numba"):
            found["pylinkage step_fast (numba)"] = pylinkage_fast
    if importable("exudyn"):
        found["exudyn"] = exudyn
    return found
