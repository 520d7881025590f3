"""What a fit costs, as far as nothing better is known."""

from __future__ import annotations

from .iso286 import Fit, tolerance_grade


def relative_cost(fit: Fit) -> float:
    """Cost of making hole and shaft of a fit, in units of that of one of them in grade IT7.

    The finer the tolerance, the dearer: the cost is taken as inverse to its width (the reciprocal model in
    K. W. Chase & W. H. Greenwood, *Design issues in mechanical tolerance analysis*, 1988), so that a grade finer costs
    some 1.6 times as much.

    Parameters
    ----------
    fit
        Tolerances of hole and shaft, as `linkframe.models.fit` looks them up.

    Returns
    -------
    float
        ``IT7 / hole's tolerance + IT7 / shaft's tolerance``.

    Examples
    --------
    >>> from linkframe.models import fit
    >>> round(relative_cost(fit(0.025, "H7/g6")), 3)  # 21/21 + 21/13
    2.615
    """
    standard = tolerance_grade(fit.hole.size, 7)
    return sum(standard / (part.upper - part.lower) for part in (fit.hole, fit.shaft))
