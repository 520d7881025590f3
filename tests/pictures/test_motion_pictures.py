"""A motion rendered in space, where rendering works, and a clear word where it does not."""

from __future__ import annotations

from pathlib import Path

import matplotlib.image
import numpy as np
import pytest
from linkframe.framework import FrameError
from linkframe.framework.pictures import plotting
from linkframe.framework.pictures.rendering import RenderingError, can_render, quiet
from linkframe.models.linkage.graphics import pictures
from linkframe.models.linkage.graphics.bodies import MotionBodies
from pictures.test_terminal import parallelogram


def test_a_picture_of_a_motion_or_a_reason(tmp_path: Path) -> None:
    motion, path = parallelogram().move(A=np.radians([0.0, 40.0])), tmp_path / "motion.png"
    if not can_render():
        with pytest.raises(RenderingError, match="was not made"):
            motion.picture(path)
        return
    motion.picture(path, pose=1, size=(300, 200))
    image = matplotlib.image.imread(path)[..., :3]
    assert image.shape == (200, 300, 3)
    assert (image[0] == 1.0).all()
    orange = (image[..., 0] > 0.6) & (image[..., 2] < 0.2) & (image[..., 1] > 0.15)
    assert orange.sum() > 20  # the drive, and a link


def test_poses_differ_when_they_are_shown_one_after_the_other() -> None:
    if not can_render():
        pytest.skip("no OpenGL here")
    bodies = MotionBodies(parallelogram().move(A=np.radians([0.0, 40.0])), (0, 1))
    with quiet():
        plotter, meshes = pictures._plotter(bodies, (120, 90), True)
        seen = []
        for pose in (0, 1, 0):
            pictures._move(plotter, meshes, bodies, pose)
            seen.append(np.asarray(plotter.screenshot(None, return_img=True)).copy())
        plotter.close()
    assert (seen[0] != seen[1]).any()
    assert (seen[0] == seen[2]).all()


def test_bad_requests_for_a_motion_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    motion = parallelogram().move(A=0.0)
    with pytest.raises(FrameError, match=r"motion\.bmp does not end in \.png or \.jpg"):
        motion.picture(tmp_path / "motion.bmp")
    monkeypatch.setattr(plotting, "can_render", lambda: True)
    with pytest.raises(FrameError, match=r"size in pixels is 0: give a whole number of 1 or more"):
        motion.picture(tmp_path / "motion.png", size=(0, 100))
    with pytest.raises(FrameError, match="rate in poses a second is 0: give a whole number of 1 or more"):
        motion.movie(tmp_path / "motion.gif", rate=0)
    monkeypatch.setattr(plotting, "find_spec", lambda name: None)
    with pytest.raises(RenderingError, match=r"pip install 'linkframe\[movie\]'"):
        motion.movie(tmp_path / "motion.gif")
    monkeypatch.setattr(plotting, "can_render", lambda: False)
    with pytest.raises(RenderingError, match="apt-get install"):
        motion.movie(tmp_path / "motion.gif")
