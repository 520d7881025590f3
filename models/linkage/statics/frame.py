"""The frame of beams, joints and springs of a linkage at every pose, with its drives locked."""

from __future__ import annotations

from collections.abc import Iterator
from copy import copy
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ....elements import Joint, PointMass
from ....elements.spring import Spring as Line
from ....framework.batch import Array, rotated
from ....framework.described.parts import IdleRotation
from ....framework.errors import FrameError
from ....framework.factor_cache import share
from ....framework.frame import Frame
from ....framework.solution import Solution
from ..description.joints import COMPONENTS
from ..description.linkage_description import LinkageDescription
from ..description.parts import GROUND, Pair, about_first, joint_axes
from ..description.sketch import place, places
from ..poses.classified import ClassifiedPoses
from .actions import rotated_tensor, tension, whole_shape
from .another_pose import at_another_pose, differs_in_place_only
from .contact import impose_contacts, without_contacts
from .guides import Layout, Slider, contact_stiffness
from .inertia import inertia, is_given
from .link_builder import LinkBuilder, joint_element
from .loading import accelerate_idle, add_inertia_loads, add_loads
from .nodes import Nodes

# Rotation about z.
ABOUT = 5


def frame(
    motion: FramedPoses, *, clearance: bool = True, loads: bool = True, inertia: bool = False, clamped: bool = False
) -> Frame:
    """Frame of the linkage at every pose, with its drives locked; see `Motion.frame`.

    With `clamped`, drives that have a stiffness are rigid too, and springs keep the force they have in the rigid
    motion.
    """
    whole_shape(motion)
    bare = motion.bare if clearance and not clamped else Builder(motion, clearance=clearance, clamped=clamped)
    built = bare.frame.copy()
    if clamped:
        for name in bare.springs:
            del built.members[name]
    if loads:
        add_loads(built, motion, bare.nodes)
    else:
        release_springs(built, bare.springs)
    if inertia:
        add_inertia_loads(built, motion, bare.nodes, bare.pieces)
        accelerate_idle(built, motion, bare.nodes)
    if clearance:
        impose_contacts(built, motion.linkage.joints)
    return built


def release_springs(built: Frame, springs: list[str]) -> None:
    """Remove the force at rest of springs, for a frame without the linkage's own loads."""
    for name in springs:
        member = built.members[name]
        assert isinstance(member.element, Line)
        built.members[name] = member._replace(element=Line(member.element.stiffness))


class Builder(LinkBuilder):
    """Builds the frame of a motion, without loads.

    Poses that are not assembled get the reference configuration and are excluded from the solution.

    Parameters
    ----------
    motion
        The motion.
    clearance
        Whether joints have their clearance.
    clamped
        Whether drives with a stiffness of their own are rigid too.
    """

    def __init__(self, motion: ClassifiedPoses, *, clearance: bool, clamped: bool = False) -> None:
        if 0 in motion.shape:
            raise FrameError(f"the motion has no poses, its shape is {motion.shape}: give the drives values")
        whole_shape(motion)
        super().__init__(motion.linkage, Frame(tolerance=motion.tolerance, made_from=motion), Nodes(motion.linkage))
        self.motion, self.clamped = motion, clamped
        self.spins = _spins(self.linkage)
        self.lost = ~motion.is_assembled
        if self.lost.any():
            self.frame.exclude(self.lost)
        for point in self.nodes.on_ground:
            self.add_ground(self.nodes.on[GROUND][point], self.linkage.points[point])
        for name, origin, axes in motion.origins_and_axes():
            self.link(name, origin, axes)
        for pair in self.linkage.joints.values():
            self.joint(pair, clearance=clearance)
        self.name_points()
        self.springs = list(self._add_springs())

    @classmethod
    def of(cls, motion: ClassifiedPoses) -> Builder:
        """Builder with clearance; that of a single pose is copied from an earlier pose where only places differ.

        Both ways give the same frame.
        """
        mechanism = motion.mechanism
        alike = differs_in_place_only(motion, _spins(motion.linkage))
        if not alike or mechanism.framed is None:
            built = cls(motion, clearance=True)
            if alike:
                # the cached copy must not keep the linkage alive that it is cached for
                mechanism.framed = kept = copy(built)
                kept.linkage, kept.frame = mechanism.linkage, built.frame.copy()
                mechanism.framed.motion = kept.frame.made_from = None
            return built
        return mechanism.framed._at(motion)  # type: ignore[no-any-return]

    def _at(self, motion: ClassifiedPoses) -> Builder:
        clone = copy(self)
        clone.motion, clone.linkage, clone.lost = motion, motion.linkage, ~motion.is_assembled
        clone.frame = at_another_pose(self.frame, motion)
        return clone

    def solve(self, loaded: Frame, *, clearance: bool = True) -> Solution:
        """Solve a loaded copy of the frame; all copies share one plan."""
        if not clearance:
            loaded = without_contacts(loaded, self.linkage.joints)
        share(self.frame, loaded)
        solution = loaded.solve(clearance=clearance)
        share(loaded, self.frame)
        return solution

    def slacken(self) -> None:
        """Set the stiffness of springs to zero, so that they keep their force at rest."""
        for name in self.springs:
            member = self.frame.members[name]
            assert isinstance(member.element, Line)
            still = replace(member.element, stiffness=np.zeros_like(member.element.stiffness))
            self.frame.members[name] = member._replace(element=still)

    def link(self, name: str, origin: Array, axes: Array) -> None:
        """Add a link: its body, nodes, beams or rigid connections, and mass."""
        sliders = list(self._sliders(name))
        origin, axes = self._there(origin, np.zeros(3)), self._there(axes, np.eye(3), 2)
        layout = self.add_link(name, origin, axes, places(self.linkage, name), sliders)
        for slider in sliders:
            self._bear(name, slider, layout)
        if is_given(self.linkage.links[name]):
            self._mass(name)

    def joint(self, pair: Pair, *, clearance: bool) -> None:
        """Add a joint element; driven directions without a given stiffness are rigid."""
        stiffness = pair.full_stiffness
        if pair.name in self.linkage.drives:
            driven = np.array([name in self.linkage.drives[pair.name] for name in COMPONENTS])
            constrained = self.clamped | ((stiffness == 0.0) & (pair.stiffness is None))
            stiffness = np.where(driven & constrained, np.inf, stiffness)
        axes = self._axes(pair)
        first, second = self._guide(pair), self.nodes.on[pair.second][pair.point]
        if pair.kind.name == "universal":
            first, stiffness = self._cross(pair, first, stiffness, axes)
        # with a given contact angle the clearance is an offset, which `frame` imposes
        element = joint_element(pair, stiffness, axes, pair.clearance if clearance and pair.contact is None else None)
        if pair.name in self.spins:
            self._constrain_spin(pair, element, first, second)
        else:
            self.add_joint(pair.name, element, first, second)

    def _constrain_spin(self, pair: Pair, ball: Joint, first: str, second: str) -> None:
        """Add a spherical joint about which a rod can spin, with the spin constrained while no load works on it.

        If the joint is equally stiff in all directions, its own element constrains the spin, otherwise a second one.
        """
        link, *ends, joints = self.spins[pair.name]
        name, about, axes = pair.name, np.arange(6) == ABOUT, self._along(link, *ends)
        constrained, free = Joint(np.where(about, np.inf, 0.0), axes), None
        if is_even(ball.stiffness):
            free, constrained = ball, replace(ball, stiffness=np.where(about, np.inf, ball.stiffness), axes=axes)
        else:
            self.frame.add(name, ball, first, second)
            name = f"{name}.spin"
        self.frame.add(name, constrained, first, second)
        self.frame.idle[name] = IdleRotation(link, (*joints, name), constrained, free)

    def _axes(self, pair: Pair) -> Array:
        """Axes of a joint, which move with its first link, in a universal joint with both links, (..., 3, 3)."""
        if pair.kind.name == "universal":
            axes = np.array(self._there(self.motion.joint_axes(pair.name), pair.axes, 2))
        elif pair.first == GROUND:
            axes = np.broadcast_to(pair.axes, (*self.motion.shape, 3, 3))
        elif pair.is_unturned:  # as most often
            axes = self.frame.bodies[pair.first].axes
        else:
            axes = np.asarray(self.frame.bodies[pair.first].axes @ pair.axes)
        axes.setflags(write=False)
        return axes

    def _guide(self, pair: Pair) -> str:
        """Node of a joint on its first link; a slider on the ground gets a node at its place."""
        name = self.nodes.guide(pair)
        if pair.kind.slides and pair.first == GROUND:
            there = self.motion.position(pair.point, pair.second)
            self.add_ground(name, self._there(there, self.linkage.points[pair.point]))
        return name

    def _cross(self, pair: Pair, first: str, stiffness: Array, axes: Array) -> tuple[str, Array]:
        """Add the cross of a universal joint, which turns about z of the first link and carries x of the second.

        Each angle is then about its own axis at any pose. Returns the node of the cross, and the stiffness between the
        cross and the second link.
        """
        about, name = np.arange(6) == ABOUT, about_first(pair)
        if pair.first == GROUND:
            self.frame.node(name, self.linkage.points[pair.point])
        else:
            self.frame.node(name, place(self.linkage, pair.first, pair.point), body=pair.first)
        self.frame.add(name, Joint(np.where(about, stiffness, np.inf), axes), first, name)
        return name, np.where(about, np.inf, stiffness)

    def _along(self, link: str, start: str, end: str) -> Array:
        """Axes with z along the line between two points of a link, (..., 3, 3)."""
        chord = place(self.linkage, link, end) - place(self.linkage, link, start)
        return self.frame.bodies[link].axes @ joint_axes(link, chord)

    def name_points(self) -> None:
        """Let the plain name of a point shared by several links stand for its node on the first of them."""
        for point, node in self.nodes.by_point.items():
            self.frame.alias(point, node)

    def _add_springs(self) -> Iterator[str]:
        """Add springs as members, whose force at rest is among the applied loads; yields their names."""
        for index, spring in enumerate(self.linkage.springs, start=1):
            if np.any(spring.stiffness):
                _, force = tension(self.motion, replace(spring, damping=np.zeros(())))
                force = self._there(force, np.zeros(()), 0)
                ends = [self.nodes.on[link][point] for link, point in (spring.first, spring.second)]
                self.frame.add(f"spring.{index}", Line(spring.stiffness, force, applied=True), *ends)
                yield f"spring.{index}"

    def _there(self, values: Array, reference: Array, trailing: int = 1) -> Array:
        """The values, replaced by `reference` at poses that are not assembled; `trailing` axes hold the components."""
        if not self.lost.any():
            return values
        return np.where(self.lost.reshape(*self.lost.shape, *(1,) * trailing), reference, values)

    def _sliders(self, link: str) -> Iterator[Slider]:
        """The sliders that run on a link, with their positions in its axes."""
        for pair in self.linkage.joints.values():
            if pair.first == link and pair.kind.slides:
                arm = self.motion.position(pair.point, pair.second) - self.motion.origin(link)
                axes = np.swapaxes(self.motion.axes(link), -1, -2)
                local = self._there(rotated(axes, arm), self.linkage.points[pair.point])
                yield Slider(self.nodes.guide(pair), pair, local)

    def _bear(self, link: str, slider: Slider, layout: Layout) -> None:
        """Add the node under a slider, rigid with the point or cut node of the link on which it stands at each pose."""
        guide, point, nodes = slider.guide, slider.pair.point, self.nodes.on[link]
        bearing_points = layout.bearing_points[guide] or {point: np.ones((), dtype=bool)}
        if guide in layout.fractions:
            return
        self.frame.node(guide, slider.place, body=link)
        if len(bearing_points) == 1:
            self.frame.rigid(*(nodes.get(each, each) for each in bearing_points), guide)
            return
        hold = contact_stiffness(self.linkage.links[link].beams, layout.at)
        for bearing_point, here in bearing_points.items():
            foot = f"{guide}.on.{bearing_point}"
            self.frame.node(foot, slider.place, body=link)
            self.frame.rigid(nodes.get(bearing_point, bearing_point), foot)
            self.frame.add(foot, Joint(np.where(here[..., None], hold, 0.0)), foot, guide)

    def _mass(self, name: str) -> None:
        """Add a given mass, rigidly attached to the link's point nearest to it."""
        own = inertia(self.linkage, name)
        point = self.nodes.centre_node(self.linkage, name, own.centre)
        axes = self.frame.bodies[name].axes
        mass = PointMass(
            own.mass, rotated_tensor(axes, own.tensor), rotated(axes, own.centre - place(self.linkage, name, point))
        )
        self.frame.add(f"{name}.mass", mass, self.nodes.on[name][point])


@dataclass(frozen=True, eq=False, repr=False)
class FramedPoses(ClassifiedPoses):
    """Poses of a linkage with their frame; see `Motion`."""

    @cached_property
    def bare(self) -> Builder:
        """The frame of the motion without loads, whose plan serves all load cases."""
        return Builder.of(self)


def _spins(linkage: LinkageDescription) -> dict[str, tuple[str, str, str, tuple[str, str]]]:
    """By joint: the link held by two spherical joints alone, which can spin about their line, both points and joints.

    The key is the first free one of the two joints in alphabetical order, so that the order of description does not
    matter.
    """
    found = {}
    for link in sorted(linkage.links):
        pairs = sorted(
            (pair for pair in linkage.joints.values() if link in (pair.first, pair.second)), key=lambda pair: pair.name
        )
        balls = [p for p in pairs if p.kind.name == "spherical" and not p.full_stiffness[..., 3:].any()]
        if not len(pairs) == len(balls) == 2 or any(pair.name in linkage.drives for pair in pairs):
            continue
        points = pairs[0].point, pairs[1].point
        free = next((pair.name for pair in pairs if pair.name not in found), None)
        if free is not None:
            found[free] = link, *points, (pairs[0].name, pairs[1].name)
    return found


def is_even(stiffness: Array) -> bool:
    """Whether a spherical joint is equally stiff in all directions, so that its axes do not matter."""
    return bool(np.all(stiffness[..., :3] == stiffness[..., :1]))
