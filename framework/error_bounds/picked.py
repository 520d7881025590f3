"""The equations in extended precision at some entries of a batch, holding data of these entries only."""

from __future__ import annotations

from ..batched.plan import Plan
from ..solvers.evaluation import Picked
from .applied import AppliedLoads
from .deformations import springs
from .equilibrium import Statics, imposed_on, six
from .kinematics import FrameKinematics
from .plan_at import plan_at


class PickedStatics(Statics):
    """A frame at some entries of its batch in extended precision.

    Parameters
    ----------
    plan
        The compiled frame.
    kinematics
        Its kinematics, at the whole batch.
    picked
        The entries (m,).
    """

    def __init__(self, plan: Plan, kinematics: FrameKinematics, picked: Picked) -> None:
        own = plan_at(plan, picked.of_array, picked.index[0].shape)
        self.plan = plan
        self.kinematics = kinematics.mapped(picked.of_array)
        self.springs = springs(own)
        self.loads = AppliedLoads.of(own, self.springs)
        links, ndim = kinematics.links, len(plan.frame.shape)
        self.stiffness = [picked.of_array(six(link.edge.stiffness, ndim), 1) for link in links]
        imposed = [imposed_on(plan, link) for link in links]
        self.imposed = [None if each is None else picked.of_array(each, 1) for each in imposed]
