"""Releases of a beam: end components, such as ``"start rz"``, that carry no force."""

from __future__ import annotations

from collections.abc import Iterable

from ..framework.errors import FrameError

ENDS = ("start", "end")
COMPONENTS = ("ux", "uy", "uz", "rx", "ry", "rz")


def parse_releases(release: Iterable[str]) -> tuple[tuple[int, int], ...]:
    """``("start rz", "end ry")`` as sorted pairs (end, component).

    Raises
    ------
    FrameError
        If an entry is not an end and a component, or if the member itself would be free to move: three releases in
        one plane of bending, or the same translation, or the twist, at both ends.
    """
    pairs = set()
    for text in (release,) if isinstance(release, str) else release:
        words = text.split() if isinstance(text, str) else ()
        if len(words) != 2 or words[0] not in ENDS or words[1] not in COMPONENTS:
            raise FrameError(f"Beam: release {text!r} must be an end and a component, such as 'start rz' or 'end ux'")
        pairs.add((ENDS.index(words[0]), COMPONENTS.index(words[1])))
    if not pairs:  # as most often
        return ()
    releases = tuple(sorted(pairs))
    for deflection, rotation in ((0, None), (3, None), (1, 5), (2, 4)):
        plane = [pair for pair in releases if pair[1] in (deflection, rotation)]
        if len(plane) > 2 or {(0, deflection), (1, deflection)} <= set(plane):
            names = ", ".join(f"{ENDS[end]} {COMPONENTS[component]}" for end, component in plane)
            raise FrameError(f"Beam: releases {names} leave the member itself free to move; keep one of them")
    return releases
