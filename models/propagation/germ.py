"""Variables of a polynomial chaos, one for each input, and the terms of its orthonormal polynomials."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...framework.errors import FrameError
from ..distributions import Distribution, Normal
from ..quantiles import is_stepped, normal_scores, probability
from .correlation import is_normal
from .inputs import JointInputs
from .orthogonal import Orthonormal

Array = NDArray[np.float64]
Powers = NDArray[np.int64]

STANDARD = Normal(0.0, 1.0)


@dataclass(frozen=True, eq=False)
class Germ:
    """Independent variables that stand for the inputs, and their polynomials.

    Parameters
    ----------
    joint
        Distribution of the k inputs.
    bases
        Polynomials of each variable.
    scored
        Whether a variable is the normal score of its input, and not the input itself; of correlated inputs all are.
    """

    joint: JointInputs
    bases: tuple[Orthonormal, ...]
    scored: tuple[bool, ...]

    @classmethod
    def of(cls, joint: JointInputs, degree: int) -> Germ:
        """The inputs themselves as variables or, if they are correlated, their independent normal scores."""
        if joint.scores is not None:
            for name, distribution in joint.distributions.items():
                if is_stepped(distribution):
                    raise FrameError(
                        f"{name!r} takes separate values only and is correlated with others, which a polynomial of "
                        "normal scores cannot follow: leave the correlation out, or take propagate"
                    )
            return cls(
                joint,
                (Orthonormal.of("score", STANDARD, degree),) * len(joint.names),
                (True,) * len(joint.distributions),
            )
        bases = tuple(Orthonormal.of(name, distribution, degree) for name, distribution in joint.distributions.items())
        return cls(joint, bases, (False,) * len(bases))

    def of_scores(self) -> Germ | None:
        """The normal scores of those inputs that are neither bounded nor normal; None where there are no such.

        Polynomials of such an input need not come near a function, whatever their degree: those of a lognormal one do
        not (O. G. Ernst, A. Mugler, H.-J. Starkloff & E. Ullmann, ESAIM: M2AN 46, 2012, doi:10.1051/m2an/2011045).
        """
        if self.joint.scores is not None:
            return None
        scored = tuple(_with_tail(distribution) for distribution in self.joint.distributions.values())
        if not any(scored):
            return None
        normal = Orthonormal.of("score", STANDARD, len(self.bases[0].a) - 1)
        bases = tuple(normal if score else own for score, own in zip(scored, self.bases, strict=True))
        return Germ(self.joint, bases, scored)

    def terms(self, powers: Powers, inputs: Mapping[str, Array]) -> Array:
        """Values of the orthonormal terms at inputs (m,) each, (m, terms)."""
        return self.terms_at(powers, self._variables(inputs))

    def terms_at(self, powers: Powers, variables: Sequence[Array]) -> Array:
        """Values of the orthonormal terms at variables (m,) each, (m, terms).

        Each is that without its last variable, which is of lower degree and stands before it, times a polynomial.
        """
        columns = [basis(each).T for basis, each in zip(self.bases, variables, strict=True)]
        out = np.ones((len(powers), columns[0].shape[1]))
        known: dict[tuple[int, ...], int] = {}
        for row, term in enumerate(map(tuple, powers.tolist())):
            known[term] = row
            last = max((k for k, power in enumerate(term) if power), default=None)
            if last is not None:
                before = known[(*term[:last], 0, *term[last + 1 :])]
                np.multiply(out[before], columns[last][term[last]], out=out[row])
        return out.T

    def _variables(self, inputs: Mapping[str, Array]) -> list[Array]:
        """Variables (m,) for each input."""
        if self.joint.scores is None:
            own = zip(self.joint.distributions.items(), self.scored, strict=True)
            return [
                normal_scores(name, distribution, inputs[name]) if to else inputs[name]
                for (name, distribution), to in own
            ]
        from scipy.special import ndtri

        at = np.stack(
            [probability(name, distribution, inputs[name]) for name, distribution in self.joint.distributions.items()]
        )
        return list(self.joint.independent(ndtri(np.clip(at, 2.0**-60, 1.0 - 2.0**-53)).T).T)


def _with_tail(distribution: Distribution) -> bool:
    """Whether a distribution is unbounded, neither normal nor stepped, and has a cumulative distribution function."""
    if is_normal(distribution) or not hasattr(distribution, "cdf") or is_stepped(distribution):
        return False
    with np.errstate(all="ignore"):
        ends = np.asarray(distribution.ppf(np.array([0.0, 1.0])), dtype=np.float64)
    return not bool(np.isfinite(ends).all())
