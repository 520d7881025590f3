"""The directive ``.. run::``: Python that is run when the site is built, with what it prints and draws below it.

All blocks of a page share their names, as typed one after another, and run in an empty folder.
"""

import contextlib
import io
import tempfile
import warnings
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from docutils import nodes
from docutils.parsers.rst import Directive

_names: dict[str, dict[str, object]] = {}  # of each page


class Run(Directive):
    """A block of Python, run."""

    has_content = True

    def run(self) -> list[nodes.Node]:
        environment = self.state.document.settings.env
        page, code = environment.docname, "\n".join(self.content)
        printed = io.StringIO()
        with (
            tempfile.TemporaryDirectory() as folder,
            contextlib.chdir(folder),
            contextlib.redirect_stdout(printed),
            warnings.catch_warnings(action="ignore"),
        ):
            exec(compile(code, f"{page}, line {self.lineno}", "exec"), _names.setdefault(page, {}))
        shown: list[nodes.Node] = [nodes.literal_block(code, code, language="python")]
        if printed.getvalue():
            text = printed.getvalue().rstrip()
            shown.append(nodes.literal_block(text, text, language="none", classes=["printed"]))
        return shown + self._figures(Path(environment.srcdir), page)

    def _figures(self, top: Path, page: str) -> list[nodes.Node]:
        folder = top / "generated" / "figures"
        folder.mkdir(parents=True, exist_ok=True)
        found: list[nodes.Node] = []
        for number in plt.get_fignums():
            name = f"{page.replace('/', '-')}-{self.lineno}-{number}.png"
            plt.figure(number).savefig(folder / name, dpi=100, bbox_inches="tight")
            found.append(nodes.image(uri=f"/generated/figures/{name}", alt=f"what line {self.lineno} draws"))
        plt.close("all")
        return found


def setup(app):
    """Make the directive known to Sphinx."""
    app.add_directive("run", Run)
    return {"parallel_read_safe": False}
