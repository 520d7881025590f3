"""Linkages in MuJoCo, an independent engine of rigid bodies: its pose from ours, and its own forces."""

from __future__ import annotations

import runpy
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from linkframe.models import Linkage, Motion
from numpy.typing import NDArray

Array = NDArray[np.float64]
EXAMPLES = Path(__file__).parents[2] / "examples"
# Examples that leave a linkage and its motion.
LINKAGES = (
    "andrews_squeezer",
    "bennett",
    "bricard",
    "cardan_shaft",
    "delta_robot",
    "excavator",
    "five_bar",
    "pictures",  # of four_bar.toml
    "rssr",
    "scissor_lift",
    "six_bar",
    "slider_crank",
    "stewart_platform",
    "three_rrr",
    "worst_case",
)


def example(name: str) -> tuple[Linkage, Motion]:
    """The linkage of an example, and its motion."""
    found = runpy.run_path(str(EXAMPLES / f"{name}.py"))
    return found["linkage"], found["motion"]


def along(linkage: Linkage, motion: Motion, count: int = 100) -> dict[str, Array]:
    """Values of the drives at so many poses on the way of a motion."""
    out = {}
    for joint, driven in linkage.drives.items():
        kind = linkage.joint(joint).kind
        values = np.broadcast_to(motion.coordinate(joint), (*motion.shape, kind.freedom)).reshape(-1, kind.freedom)
        (k,) = (kind.coordinates.index(name) for name in driven)
        out[joint] = np.interp(np.linspace(0.0, 1.0, count), np.linspace(0.0, 1.0, len(values)), values[:, k])
    return out


class Engine:
    """A model of MuJoCo that was written of a linkage, put where the linkage is.

    Parameters
    ----------
    model
        The model.
    motion
        The linkage at poses (n,).
    """

    def __init__(self, model: Any, motion: Motion) -> None:
        import mujoco

        self.mujoco, self.model, self.data, self.motion = mujoco, model, mujoco.MjData(model), motion
        self.joints = [model.joint(k) for k in range(model.njnt)]
        # what the motion says is asked once, for all poses
        self._of, self._axes, self._spin = cache(self._of), cache(self._axes), cache(self._spin)  # type: ignore
        self._links = {joint.id: self._ends(joint) for joint in self.joints}
        self.sites = {
            (link, point): model.site(point if link == motion.linkage.end(point)[0] else f"{point} on {link}").id
            for link, own in motion.linkage.links.items()
            for point in own.points
        }

    def put(self, pose: int) -> None:
        """Coordinates and rates of one pose; everything that follows from them."""
        for joint in self.joints:
            if joint.type[0] == self.mujoco.mjtJoint.mjJNT_BALL:
                self._put_ball(joint, pose)
                continue
            coordinate, rate, _ = self._of(joint.name)
            self.data.qpos[joint.qposadr[0]], self.data.qvel[joint.dofadr[0]] = coordinate[pose], rate[pose]
        self.mujoco.mj_forward(self.model, self.data)

    def accelerations(self, pose: int) -> Array:
        """Second derivatives of the coordinates of one pose; of a ball in the axes of its body."""
        out = np.zeros(self.model.nv)
        for joint in self.joints:
            at = joint.dofadr[0]
            if joint.type[0] == self.mujoco.mjtJoint.mjJNT_BALL:
                parent, child = self._links[joint.id]
                alpha = self._spin(child, 1)[pose] - self._spin(parent, 1)[pose]
                relative = self._spin(child, 0)[pose] - self._spin(parent, 0)[pose]
                alpha = alpha - np.cross(self._spin(parent, 0)[pose], relative)
                out[at : at + 3] = self._axes(child)[pose].T @ alpha
            else:
                out[at] = self._of(joint.name)[2][pose]
        return out

    def _of(self, name: str) -> tuple[Array, Array, Array]:
        """Coordinate, rate and acceleration of a joint that turns or slides."""
        motion = self.motion
        joint, component = (name, "") if name in motion.linkage.joints else name.rsplit(" ", 1)
        pair = motion.linkage.joint(joint)
        all_three = motion.coordinate(joint), motion.coordinate_rate(joint), motion.coordinate_acceleration(joint)
        if pair.kind.name == "screw" and component == "uz":
            assert pair.pitch is not None
            turned = all_three[0] - pair.reference, all_three[1], all_three[2]
            return tuple(float(pair.pitch) / (2.0 * np.pi) * x[..., 0] for x in turned)  # type: ignore[return-value]
        k = pair.kind.coordinates.index(component) if component else 0
        return tuple(x[..., k] for x in all_three)  # type: ignore[return-value]

    def _put_ball(self, joint: Any, pose: int) -> None:
        parent, child = self._links[joint.id]
        first, second = self._axes(parent)[pose], self._axes(child)[pose]
        turned = np.zeros(4)
        self.mujoco.mju_mat2Quat(turned, np.ascontiguousarray(first.T @ second).ravel())
        self.data.qpos[joint.qposadr[0] : joint.qposadr[0] + 4] = turned
        rate = second.T @ (self._spin(child, 0)[pose] - self._spin(parent, 0)[pose])
        self.data.qvel[joint.dofadr[0] : joint.dofadr[0] + 3] = rate

    def _ends(self, joint: Any) -> tuple[str, str]:
        body = self.model.body(joint.bodyid[0])
        return tuple(self.model.body(k).name.split(" at ")[0] for k in (body.parentid[0], body.id))  # type: ignore

    def _axes(self, link: str) -> Array:
        unit = np.broadcast_to(np.eye(3), (*self.motion.shape, 3, 3))
        return unit if link == "world" else self.motion.axes(link)

    def _spin(self, link: str, order: int) -> Array:
        if link == "world":
            return np.zeros((*self.motion.shape, 3))
        return self.motion.angular_acceleration(link) if order else self.motion.angular_velocity(link)

    # -- what it says -----------------------------------------------------------------------------------------------

    @property
    def positions(self) -> Array:
        """Where the sites of all points of all links are, (sites, 3)."""
        return np.asarray(self.data.site_xpos[list(self.sites.values())])

    @property
    def gap(self) -> float:
        """By how much the loops are open at most."""
        return float(np.abs(self.data.efc_pos[: self.data.ne]).max(initial=0.0))

    @property
    def kinetic_energy(self) -> float:
        """Of all bodies."""
        moved = np.zeros(self.model.nv)
        self.mujoco.mj_mulM(self.model, self.data, moved, self.data.qvel)
        return float(self.data.qvel @ moved) / 2.0

    def solve(self, pose: int) -> dict[str, float]:
        """Forces of the drives at the accelerations of one pose, by inverse dynamics; forces of constraints likewise.

        They are those which with the Jacobian of the constraints and the drives balance what the tree of joints needs:
        least squares, not the engine's own soft constraints.
        """
        model, data, mujoco = self.model, self.data, self.mujoco
        driven = [k for k in range(model.nu) if model.actuator_trntype[k] == mujoco.mjtTrn.mjTRN_JOINT]
        moments = np.zeros((model.nu, model.nv))
        rows = data.moment_rownnz, data.moment_rowadr, data.moment_colind
        mujoco.mju_sparse2dense(moments, data.actuator_moment, *rows)
        acceleration, needed = self.accelerations(pose), np.zeros(model.nv)
        mujoco.mj_mulM(model, data, needed, acceleration)
        loads = [k for k in range(model.nu) if k not in driven]
        needed += data.qfrc_bias - data.qfrc_passive - moments[loads].T @ data.actuator_force[loads]
        matrix = np.vstack([self._constraints(), moments[driven]]).T
        found = np.linalg.lstsq(matrix, needed, rcond=1e-10)[0]
        assert np.abs(matrix @ found - needed).max() < 1e-9 * max(np.abs(needed).max(), 1e-30)
        data.qacc[:], data.efc_force[:] = acceleration, found[: data.nefc]
        mujoco.mj_rnePostConstraint(model, data)
        return {model.actuator(k).name: float(force) for k, force in zip(driven, found[data.nefc :], strict=True)}

    def _constraints(self) -> Array:
        data, shape = self.data, (self.data.nefc, self.model.nv)
        if not self.mujoco.mj_isSparse(self.model):
            return np.asarray(data.efc_J).reshape(shape)
        dense = np.zeros(shape)
        self.mujoco.mju_sparse2dense(dense, data.efc_J, data.efc_J_rownnz, data.efc_J_rowadr, data.efc_J_colind)
        return dense

    def on_body(self, link: str) -> Array:
        """Force and moment on a body by what carries it, about its origin, global; after `solve`."""
        body = self.model.body(link).id
        wrench = self.data.cfrc_int[body]
        arm = self.data.subtree_com[self.model.body_rootid[body]] - self.data.xpos[body]
        return np.concatenate([wrench[3:], wrench[:3] + np.cross(arm, wrench[3:])])

    def at_closure(self, name: str) -> Array:
        """Force of one loop closure on its first body, global; after `solve`."""
        of = self.model.equality(name).id
        rows = (self.data.efc_id[: self.data.nefc] == of) & (np.arange(self.data.nefc) < self.data.ne)
        return np.asarray(self.data.efc_force[rows])
