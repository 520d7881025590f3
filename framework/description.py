"""The description of a frame: nodes, members, joints, supports and loads, each number possibly a batch."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .described.loads import DescribedLoads
from .dofs import DISPLACEMENTS, FORCES
from .errors import FrameError
from .listing import html_table


class Description(DescribedLoads):
    """Parts, supports and loads of a frame, as data alone.

    `linkframe.framework.Frame` adds the analyses; its docstring lists the attributes.
    """

    def exclude(self, where: ArrayLike) -> None:
        """Leave batch entries out, such as poses that a linkage cannot take.

        Such entries still need some finite numbers in the description; their status is ``absent``, their results NaN.

        Parameters
        ----------
        where
            True for the entries to leave out, (...).

        Raises
        ------
        FrameError
            If `where` does not broadcast with the batch.

        Examples
        --------
        >>> from linkframe.framework import Frame
        >>> frame = Frame()
        >>> frame.node("A", (0.0, 0.0, 0.0)); frame.fix("A")
        >>> frame.load("A", fx=[1.0, 2.0, 3.0]); frame.exclude([False, True, False])
        >>> frame.solve().status.tolist()
        ['regular', 'absent', 'regular']
        """
        left = np.array(where)
        if left.dtype != np.bool_:
            raise FrameError(f"exclude was given {where!r}: give True for the entries to leave out")
        self._join({"entries left out": left.shape})
        self.absent = left if self.absent is None else self.absent | left

    def __repr__(self) -> str:
        parts = {"node": len(self.nodes), "member": len(self.members), "joint": len(self.joints)}
        counts = ", ".join(f"{count} {name}{'' if count == 1 else 's'}" for name, count in parts.items())
        return f"<Frame of shape {self.shape}: {counts}>"

    def _repr_html_(self) -> str:
        """Table for a notebook: each member, joint, support and load by name."""
        rows = [
            *([name, "member", f"{ends.start} to {ends.end}"] for name, ends in self.members.items()),
            *([name, "joint", f"{ends.first} to {ends.second}"] for name, ends in self.joints.items()),
            *(
                [name, "support", " ".join(DISPLACEMENTS[k] for k in sorted(components))]
                for name, components in self.supports.items()
            ),
            *([name, "load", " ".join(sorted({FORCES[k] for k, _ in given}))] for name, given in self.loads.items()),
        ]
        return html_table(repr(self).strip("<>"), ["name", "what", "where"], rows)


def excluding(frame: Description, where: NDArray[np.bool_]) -> Description:
    """Copy of a description in which the batch entries `where`, a boolean array (...), are left out as well."""
    clone = frame.copy()
    clone.exclude(where)
    return clone


def alone(frame: Description) -> Description:
    """The description without its `made_from`: a shallow copy, which shares all dicts; itself where it has none."""
    if frame.made_from is None:
        return frame
    clone = object.__new__(type(frame))
    for name, value in vars(frame).items():
        setattr(clone, name, value)
    clone.made_from = None
    return clone
