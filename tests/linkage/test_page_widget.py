"""The page as a widget: its traits without a browser, and its module in one, between a model and the page."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from linkage.browser import SET, Browser
from linkage.test_page import TOLERANCES, chain, four_bar
from linkframe.framework import FrameError
from linkframe.models.linkage.page import page as page_module
from numpy.testing import assert_allclose

MODULE = Path(page_module.__file__).with_name("widget.js")


def test_traits() -> None:
    pytest.importorskip("anywidget")
    motion = four_bar()
    shown = motion.widget("P", **TOLERANCES)
    assert (shown.pose, shown.load, shown.factors) == (0, 1.0, [1.0] * 5)
    heard: list[Any] = []
    shown.observe(lambda change: heard.append(change["new"]), "pose")
    shown.pose = 7
    shown.factors = [2.0, 1.0, 0.5, 0.0, 3.0]
    assert heard == [7]
    assert shown.drives == {"A": pytest.approx(np.radians(35.0))}
    assert shown.clearances == {"B": pytest.approx(1e-4), "C": pytest.approx(8e-5), "D": pytest.approx(2.5e-5)}
    assert shown.deviations["length crank"] == 0.0
    assert shown.deviations["drive A"] == pytest.approx(3e-4)
    again = motion.linkage.move(**shown.drives).worst_case("P", clearances=shown.clearances)
    assert_allclose(again.greatest, motion.worst_case("P", clearances=shown.clearances).greatest[7], rtol=1e-9)
    assert "srcdoc" in shown._esm
    assert "Where P goes" in shown.page
    with pytest.raises(Exception, match="pose = 72: give 0 to 71"):
        shown.pose = 72
    with pytest.raises(Exception, match="give one for each of"):
        shown.factors = [1.0]


def test_without_deviations() -> None:
    pytest.importorskip("anywidget")
    shown = chain(np.linspace(0.0, 0.3, 5)).widget("C")
    assert (shown.deviations, shown.clearances, shown.factors) == ({}, {}, [])
    with pytest.raises(FrameError, match="a widget of 1000 poses: give at most 721"):
        chain(np.linspace(0.0, 0.3, 1000)).widget("C")


def test_the_module_between_a_model_and_the_page(browser: Browser, tmp_path: Path) -> None:
    """As a notebook has it: a model with traits, the module, and the page in a frame that may do nothing but run."""
    motion = four_bar()
    motion.page(tmp_path / "four.html", "P", **TOLERANCES)
    page = json.dumps((tmp_path / "four.html").read_text(encoding="utf-8")).replace("<", "\\u003c")
    program = MODULE.read_text(encoding="utf-8").replace("export default", "const made =")
    (tmp_path / "notebook.html").write_text(
        f"""<!DOCTYPE html><meta charset="utf-8"><div id="cell"></div><script>{program}
        window.traits = {{ page: {page}, height: 620, pose: 3, load: 1, factors: [1, 1, 1, 1, 1], numbers: {{}} }};
        window.saved = 0;
        const heard = {{}};
        window.model = {{
          get: (name) => traits[name],
          set: (name, value) => {{ traits[name] = value; heard[`change:${{name}}`]?.(); }},
          on: (what, call) => {{ heard[what] = call; }},
          off: (what) => {{ delete heard[what]; }},
          save_changes: () => {{ saved += 1; }},
        }};
        window.close = made.render({{ model, el: document.getElementById("cell") }});
        </script>""",
        encoding="utf-8",
    )
    browser.open(tmp_path / "notebook.html")
    traits = "const { page, ...rest } = traits; return rest;"
    found = browser.wait(traits, lambda found: found["numbers"])
    # What Python had set before it was shown stands on the page.
    assert found["pose"] == 3
    assert_allclose(found["numbers"]["P, x [m]"], motion.position("P")[3, 0], rtol=1e-11)
    # What is moved on the page comes back,
    with browser.frame(0):
        browser.run(SET, {"pose": "12", "load": "0.5", "limit-1": "2"})
    found = browser.wait(traits, lambda found: found["pose"] == 12 and found["load"] == 0.5)
    assert found["factors"] == [1, 2, 1, 1, 1]
    given = {"clearances": {"B": 5e-5, "C": 1.6e-4, "D": 5e-5}}
    worst = motion.worst_case("P", **TOLERANCES, **given)
    words = "P by clearances and tolerances, at most [m]"
    assert_allclose(found["numbers"][words], worst.greatest[12], rtol=1e-9)
    assert browser.run("return saved") > 0
    # and what Python sets then is shown.
    browser.run("model.set('pose', 30)")
    found = browser.wait(traits, lambda found: abs(found["numbers"]["P, x [m]"] - motion.position("P")[30, 0]) < 1e-11)
    assert found["pose"] == 30
