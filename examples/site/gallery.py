"""The scripts of examples/ as sphinx-gallery wants them: a title, the sketch as it was typed, a figure, a live page."""

import ast
import runpy
import shutil
import textwrap
from pathlib import Path

# These two draw README's pictures from the linkages of the other scripts.
LEFT_OUT = {"four_bar_picture", "linkage_pictures"}
# Words of the names of scripts that are not spelt as they stand there.
SPELT = {"rssr": "RSSR", "rrr": "RRR", "bennett": "Bennett", "bricard": "Bricard", "stewart": "Stewart"}
# Name of the script: the point that its figure and its live page follow, for scripts that leave a `motion`.
FOLLOWED = {
    "andrews_squeezer": "E",
    "cardan_shaft": "E",
    "delta_robot": "P",
    "excavator": "E",
    "five_bar": "P",
    "rssr": "B",
    "scissor_lift": "L4",
    "six_bar": "P",
    "slider_crank": "C",
    "stewart_platform": "P",
    "three_rrr": "P",
    "worst_case": "P",
}
# Name of the script: the point that its live page follows, and what makes its motion where the script leaves none that
# a page can show; for scripts whose figure shows something else.
PAGED = {
    "bennett": ("H2", ""),
    "bricard": ("H3", ""),
    "four_bar": (
        "P",
        "drawn = FourBar(crank=0.1, coupler=0.2, rocker=0.1, ground=0.2, point=(0.1, 0.0))\n"
        "linkage = drawn.linkage(np.radians(40.0))\n"
        'linkage.load("P", fy=100.0)\nmotion = linkage.move(A=theta)',
    ),
    "gravity_spring_rpm": ("C", ""),
    "loose_pins": (
        "P",
        'linkage = FourBar(crank=0.3, coupler=0.9, rocker=0.8, ground=0.7, point=(0.5, 0.2), branch="open").linkage('
        '0.0, clearance)\nlinkage.load("P", fy=100.0)\nmotion = linkage.move(A=theta[::3])',
    ),
    "measured_data": ("P", ""),
    "optimal_six_bar": ("P", "motion = six_bar(found.x).move(A=THETA)"),
    "own_linkage_study": ("D", ""),
    "pictures": ("P", ""),
    "reliability": ("C", ""),
    "workspace_stiffness": (
        "P",
        "row = space.reached[12]\n"
        "motion = linkage.move({name: drive[12][row] for name, drive in space.drives.items()})",
    ),
}
# What the other scripts show, drawn.
BEND = "import matplotlib.pyplot as plt\n\n"
DRAWN = {
    "batch_sweep": 'solution.plot("deformed", entry=(0, 0))',
    "bennett": 'motion.plot(trace="H2")',
    "bricard": 'motion.plot(trace="H3")',
    "cantilever": 'solution.plot("M")',
    "four_bar": BEND + 'plt.semilogy(np.degrees(theta), compliance)\nplt.xlabel("crank [°]")\n'
    'plt.ylabel("P under 100 N [m]")\nplt.tight_layout()',
    "gravity_spring_rpm": 'reactions.plot("drives")',
    "loose_pins": BEND + 'plt.plot(np.degrees(theta), 1e6 * by_clearance)\nplt.xlabel("crank [°]")\n'
    'plt.ylabel("displacement of P by clearance [µm]")',
    "measured_data": "nominal.plot()",
    "optimal_six_bar": 'six_bar(found.x).move(A=THETA).plot(trace="P")',
    "own_cable": 'solution.plot("deformed", entry=0)',
    "own_foundation": 'frame.solve().plot("deformed", entry=0)',
    "own_hardening_spring": BEND + 'plt.plot(force, 1e3 * elongation, "o-", label="hardening")\n'
    'plt.plot(force, 1e3 * linear.displacement("B")[:, 0], "--", label="linear")\n'
    'plt.legend()\nplt.xlabel("force [N]")\nplt.ylabel("elongation [mm]")',
    "own_heated_beam": 'frame.solve().plot("M", entry=1)',
    "own_linkage_study": 'found.contributors["D"].plot()',
    "own_truss": 'frame.solve().plot("deformed", entry=0)',
    "pictures": 'solution.plot("M", entry=pose)',
    "portal_frame": 'solution.plot("M")',
    "reliability": 'motion.plot(trace="C")',
    "scikit_fem_form": 'solution.plot("M", entry=0)',
    "sizing": 'solution.plot("N")',
    "three_hinged_frame": 'solution.plot("M")',
    "workspace_stiffness": 'space.plot("stiffness")',
}


def prepare(scripts: Path, target: Path, live: Path) -> None:
    """Write the scripts in folder `scripts` to `target`, and their live pages to ``live/pages``."""
    shutil.rmtree(target, ignore_errors=True)
    target.mkdir(parents=True)
    (live / "pages").mkdir(parents=True, exist_ok=True)
    (target / "README.rst").write_text(INTRODUCTION, encoding="utf-8")
    for data in scripts.glob("*.toml"):
        shutil.copy(data, target)
    for script in sorted(scripts.glob("*.py")):
        if script.stem not in LEFT_OUT:
            (target / script.name).write_text(_titled(script), encoding="utf-8")
            if script.stem in FOLLOWED or script.stem in PAGED:
                _page(script, live / "pages" / f"{script.stem}.html")


def _page(script: Path, page: Path) -> None:
    point, motion = PAGED.get(script.stem, (FOLLOWED.get(script.stem), ""))
    names = runpy.run_path(str(script))
    exec(motion, names)
    names["motion"].page(page, point, title=_name(script))


def _name(script: Path) -> str:
    """What a script is called on the site."""
    words = [SPELT.get(word, word) for word in script.stem.replace("scikit_fem", "scikit-fem").split("_")]
    return " ".join([words[0][:1].upper() + words[0][1:], *words[1:]])


def _titled(script: Path) -> str:
    """The script with its docstring as a page: first sentence as title, the rest as it was typed."""
    source = script.read_text(encoding="utf-8")
    tree = ast.parse(source)
    title, _, sketch = (ast.get_docstring(tree, clean=False) or "").partition("\n")
    rest = "\n".join(source.splitlines()[tree.body[0].end_lineno :]).strip().replace("__file__", repr(script.name))
    name = _name(script)
    page = [name, "=" * len(name), "", title.replace("\\", "\\\\")]
    if script.stem in FOLLOWED or script.stem in PAGED:
        link = f"../../pages/{script.stem}.html"
        page += ["", f"`Live page <{link}>`__: drag the drive, move the sliders."]
        page += [
            "",
            ".. raw:: html",
            "",
            f'    <iframe class="live" src="{link}" title="{name}" loading="lazy"></iframe>',
        ]
    page += ["", ".. code-block:: text", "", textwrap.indent(textwrap.dedent(sketch).strip("\n"), "    ")]
    drawn = DRAWN.get(script.stem) or f'motion.plot(trace="{FOLLOWED[script.stem]}")'
    return 'r"""' + "\n".join(page) + f'\n"""\n\n{rest}\n\n# %%\n# Drawn:\n\n{drawn}\n'


INTRODUCTION = """Gallery
=======

Every script of the folder `examples`, run when this site was built. The tests check each of them against a closed form
or a published value.
"""
