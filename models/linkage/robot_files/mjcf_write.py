"""Write a linkage as MJCF, the format of MuJoCo: bodies, joints, loop closures, drives, springs, loads."""

from __future__ import annotations

from xml.etree.ElementTree import Element

import numpy as np

from ....framework import rotation
from ....framework.batch import Array
from ....framework.errors import FrameError
from ..description.linkage_description import LinkageDescription
from ..description.parts import GROUND, Pair
from .body_tree import BodyTree, LoopClosure, TreeBody, TreeStep, advance_of, body_tree
from .drive_gains import Gains, drive_gains
from .placed import single
from .xml import Number, add, check_unique, document, note

WORLD = "world"
TIME_STEP = 1e-3
# Constraints of loops are as stiff as MuJoCo allows: their errors decay within two time steps.
SOLVER = {"solref": (2.0 * TIME_STEP, 1.0), "solimp": (0.999, 0.9999, 1e-3, 0.5, 2.0)}
# Distance of the second point on the axis of a hinge from the first, and thickness of links in drawings, in sizes of
# the linkage.
ON_AXIS, THICK = 0.25, 0.01
# Largest depth of nested bodies that MuJoCo reads.
DEEPEST = 450
# Names of elements that only the format needs: notes of links without mass, and a site with the axes of the ground.
MASSLESS, AXES_OF_LOADS = "without mass: ", "axes of loads"
# Groups of elements in which names must be unique.
NAMED = {
    "bodies": "worldbody//body",
    "joints": "worldbody//joint",
    "sites": "worldbody//site",
    "loop closures": "equality/*",
    "drives and loads": "actuator/*",
}
# A constant force, without any signal: gain 0, and a bias of 1 times the gear.
CONSTANT = {"gaintype": "fixed", "gainprm": "0", "biastype": "affine", "biasprm": "1 0 0"}


def mjcf(linkage: LinkageDescription, title: str) -> str:
    """The text of the file.

    Raises
    ------
    FrameError
        As for `body_tree`, or if springs, loads or gravity have a batch.
    """
    check_names(linkage)
    return MjcfWriter(body_tree(linkage), title).text()


class MjcfWriter:
    """Writer of one linkage.

    Parameters
    ----------
    tree
        The linkage on its tree.
    title
        Name of the model.
    """

    def __init__(self, tree: BodyTree, title: str) -> None:
        self.tree, self.linkage, self.size = tree, tree.linkage, tree.placed.size
        self.root = Element("mujoco", model=title)
        self.sites: dict[tuple[str, str], str] = {}
        self.elements: dict[str, Element] = {}
        self.origins: dict[str, Array] = {GROUND: np.zeros(3)}
        self.depths = {GROUND: 0}

    def text(self) -> str:
        """The whole file."""
        self._settings()
        world = self.elements[GROUND] = add(self.root, "worldbody")
        self._ground_points(world)
        for body in self.tree.bodies:
            self._body(body)
        self._equalities()
        self._springs()
        self._actuators()
        self._notes()
        for group, where in NAMED.items():
            check_unique([each.get("name", "") for each in self.root.findall(where)], group)
        return document(self.root)

    def _settings(self) -> None:
        add(self.root, "compiler", angle="radian", autolimits="true", inertiafromgeom="false")
        gravity = single(self.linkage.weight, 1, "gravity")
        option = add(
            self.root, "option", timestep=TIME_STEP, gravity=gravity, integrator="implicitfast", solver="Newton",
            iterations=100.0, tolerance=1e-12,
        )  # fmt: skip
        add(option, "flag", contact="disable")
        default = add(self.root, "default")
        add(default, "equality", **SOLVER)
        add(default, "geom", contype="0", conaffinity="0", mass="0", rgba="0.45 0.55 0.7 1")
        add(default, "site", size=1.5 * THICK * self.size, rgba="0.9 0.5 0.1 1")
        light = {"ambient": "0.45 0.45 0.45", "diffuse": "0.55 0.55 0.55", "specular": "0.1 0.1 0.1"}
        add(add(self.root, "visual"), "headlight", **light)
        sky = {"builtin": "flat", "rgb1": "0.97 0.97 0.97", "rgb2": "0.97 0.97 0.97", "width": "16", "height": "96"}
        add(add(self.root, "asset"), "texture", type="skybox", **sky)

    # -- bodies -----------------------------------------------------------------------------------------------------

    def _ground_points(self, world: Element) -> None:
        """Add sites for points that are on no link, and for those where springs end on the ground."""
        linkage = self.linkage
        on_links = {point for link in linkage.links.values() for point in link.points}
        ends = {end[1] for spring in linkage.springs for end in (spring.first, spring.second) if end[0] == GROUND}
        for point, place in linkage.points.items():
            if point not in on_links or point in ends:
                self._site(world, GROUND, point, place)

    def _site(self, element: Element, link: str, point: str, place: Array) -> None:
        """Add a site for a point: with its own name on the first link that has it, as ``B on coupler`` on others."""
        first = self.linkage.end(point)[0]
        name = self.sites[link, point] = point if link == first else f"{point} on {link}"
        add(element, "site", name=name, pos=place)

    def _body(self, body: TreeBody) -> None:
        element = add(self.elements[body.parent], "body", name=body.name, pos=body.origin - self.origins[body.parent])
        self.elements[body.name], self.origins[body.name] = element, body.origin
        self.depths[body.name] = self.depths[body.parent] + 1
        if self.depths[body.name] > DEEPEST:
            raise FrameError(f"more than {DEEPEST} links hang one on another, which MuJoCo does not read: write TOML")
        own = body.mass
        add(element, "inertial", pos=own.centre - body.origin, mass=own.mass, **_principal(own.tensor))
        for step in body.steps:
            self._joint(element, step)
        if body.part_of is None:
            for point, place in body.points.items():
                self._site(element, body.name, point, place - body.origin)
        for pair in body.lines:
            ends = np.concatenate([body.points[point] - body.origin for point in pair])
            if np.any(ends[:3] != ends[3:]):
                add(element, "geom", type="capsule", fromto=ends, size=THICK * self.size)
        if not body.lines:
            add(element, "geom", type="sphere", size=2.0 * THICK * self.size)

    def _joint(self, element: Element, step: TreeStep) -> None:
        if step.component == "ball":
            add(element, "joint", name=step.name, type="ball")
            return
        kind = "hinge" if step.is_rotation else "slide"
        given: dict[str, Number] = {"ref": step.reference} if step.reference else {}
        add(element, "joint", name=step.name, type=kind, axis=step.axis, **given)

    # -- loops ------------------------------------------------------------------------------------------------------

    def _equalities(self) -> None:
        screws = [body for body in self.tree.bodies if body.joint.kind.name == "screw"]
        if not self.tree.closures and not screws:
            return
        element = add(self.root, "equality")
        for body in screws:
            self._screw(element, body.joint)
        for closure in self.tree.closures:
            self._closure(element, closure)

    def _screw(self, element: Element, pair: Pair) -> None:
        names = {f"joint{k}": f"{pair.name} {component}" for k, component in ((1, "uz"), (2, "rz"))}
        add(element, "joint", name=pair.name, polycoef=(0.0, advance_of(pair), 0.0, 0.0, 0.0), **names)

    def _closure(self, element: Element, closure: LoopClosure) -> None:
        """Add a loop closure: one shared point for a spherical joint, two on the axis for a hinge, else a weld."""
        one, other = closure.first, closure.second
        if one == GROUND:
            one, other = other, one
        bodies = {"body1": one} | ({} if other == GROUND else {"body2": other})
        if closure.kind == "fixed":
            add(element, "weld", name=closure.name, **bodies)
            return
        anchor = closure.place - self.origins[one]
        add(element, "connect", name=closure.name, anchor=anchor, **bodies)
        if closure.kind == "revolute":
            further = anchor + ON_AXIS * self.size * closure.axis
            add(element, "connect", name=f"{closure.name} axis", anchor=further, **bodies)

    # -- what acts --------------------------------------------------------------------------------------------------

    def _springs(self) -> None:
        if not self.linkage.springs:
            return
        element = add(self.root, "tendon")
        for number, spring in enumerate(self.linkage.springs):
            values = {"stiffness": spring.stiffness, "damping": spring.damping, "springlength": spring.length}
            given = {key: single(value, 0, f"{key} of spring {number}") for key, value in values.items()}
            tendon = add(element, "spatial", name=f"spring {number}", **given)
            for end in (spring.first, spring.second):
                add(tendon, "site", site=self.sites[end])

    def _actuators(self) -> None:
        if not self.linkage.drives and not self.linkage.loads:
            return
        element = add(self.root, "actuator")
        steps = self.tree.steps
        for joint, coordinates in self.linkage.drives.items():
            gains = drive_gains(self.tree.placed, joint)
            if self.linkage.joints[joint].kind.name == "spherical":
                self._ball_drive(element, joint, gains[0])
                continue
            for coordinate, own in zip(coordinates, gains, strict=True):
                name = joint if joint in steps else f"{joint} {coordinate}"
                add(element, "position", name=name, joint=name, kp=own.stiffness, kv=own.damping)
        self._loads(element)
        self._reference(element)

    def _ball_drive(self, element: Element, joint: str, gains: Gains) -> None:
        body = next(body for body in self.tree.bodies if body.joint.name == joint)
        axes = self.tree.placed.axes(body.joint) * (-1.0 if body.is_reversed else 1.0)
        for k, component in enumerate(("rx", "ry", "rz")):
            name = f"{joint} {component}"
            gear = np.append(axes[:, k], np.zeros(3))
            add(element, "position", name=name, joint=joint, gear=gear, kp=gains.stiffness, kv=gains.damping)

    def _reference(self, actuators: Element) -> None:
        """Add a keyframe in which the drives keep their reference values."""
        steps = self.tree.steps
        signals = [steps[own.get("joint", "")].reference if own.tag == "position" else 0.0 for own in actuators]
        add(add(self.root, "keyframe"), "key", name="reference", ctrl=signals)

    def _loads(self, element: Element) -> None:
        """Add constant forces on sites: along axes of the ground, or for follower loads along those of the site."""
        if any(not load.follower for load in self.linkage.loads):
            add(self.elements[GROUND], "site", name=AXES_OF_LOADS)
        for number, load in enumerate(self.linkage.loads):
            if load.link == GROUND:
                continue
            value = single(load.value, 1, f"load {number} on link {load.link!r}")
            site = self.sites[load.link, load.point or self.linkage.links[load.link].points[0]]
            fixed = {} if load.follower else {"refsite": AXES_OF_LOADS}
            add(element, "general", name=f"load {number}", site=site, gear=value, **CONSTANT, **fixed)

    def _notes(self) -> None:
        """Add notes that name links without mass, so that the small mass written for them is not read back."""
        light = [body.name for body in self.tree.bodies if not body.mass.is_own and body.part_of is None]
        if light:
            custom = add(self.root, "custom")
            for name in light:
                add(custom, "text", name=f"{MASSLESS}{name}", data="something light stands for the mass of this link")
        note(
            self.root, "Angles in radians, joint coordinates as linkframe has them: see linkframe.models.write_linkage."
        )


def _principal(tensor: Array) -> dict[str, Number]:
    """Principal moments of inertia, and their directions if these are not the axes of the body."""
    if np.array_equal(tensor, np.diag(np.diag(tensor))):
        return {"diaginertia": np.diag(tensor)}
    moments, axes = np.linalg.eigh(tensor)
    axes[:, 2] *= np.sign(np.linalg.det(axes))
    return {"diaginertia": moments, "quat": rotation.of_matrix(axes)}


def check_names(linkage: LinkageDescription) -> None:
    """Refuse names of links that the formats use for the ground.

    Raises
    ------
    FrameError
        If a link is called ``world``.
    """
    if WORLD in linkage.links:
        raise FrameError("link 'world': in MJCF and SDF that is the ground; give the link another name")
