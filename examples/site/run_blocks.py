"""Directives that run what a page shows when the site is built, with what it prints, draws and writes for a browser.

``.. run::`` is Python, ``.. shell::`` commands of ``linkframe``. All blocks of a page share their names and one folder,
as typed one after another.
"""

import contextlib
import io
import re
import shlex
import shutil
import tempfile
import warnings
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from docutils import nodes
from docutils.parsers.rst import Directive

_names: dict[str, dict[str, object]] = {}  # of each page
_folders: dict[str, tempfile.TemporaryDirectory] = {}
# Lines of progress, which come and go on a terminal.
PROGRESS = re.compile(r"^.*(?:s so far|no estimate yet|s to go)$\n?", flags=re.MULTILINE)


class Run(Directive):
    """A block of Python, run."""

    has_content = True
    language = "python"

    def run(self) -> list[nodes.Node]:
        environment = self.state.document.settings.env
        page, code = environment.docname, "\n".join(self.content)
        folder = Path(_folders.setdefault(page, tempfile.TemporaryDirectory()).name)
        printed = io.StringIO()
        with (
            contextlib.chdir(folder),
            contextlib.redirect_stdout(printed),
            warnings.catch_warnings(action="ignore"),
        ):
            self.execute(code, page)
        shown: list[nodes.Node] = [nodes.literal_block(code, code, language=self.language)]
        if text := PROGRESS.sub("", printed.getvalue()).replace(f"{folder}/", "").strip("\n"):
            shown.append(nodes.literal_block(text, text, language="none", classes=["printed"]))
        return (
            shown + self._figures(Path(environment.srcdir), page) + self._pages(Path(environment.srcdir), folder, page)
        )

    def execute(self, code: str, page: str) -> None:
        """Run the block in the folder of its page."""
        exec(compile(code, f"{page}, line {self.lineno}", "exec"), _names.setdefault(page, {}))

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

    def _pages(self, top: Path, folder: Path, page: str) -> list[nodes.Node]:
        """What the block has written for a browser, to be tried on the spot."""
        live = top / "generated" / "live" / "pages"
        live.mkdir(parents=True, exist_ok=True)
        found: list[nodes.Node] = []
        for made in sorted(folder.rglob("*.html")):
            name = f"{page.replace('/', '-')}-{made.stem}.html"
            shutil.move(made, live / name)
            up = "../" * page.count("/")
            frame = f'<iframe class="live" src="{up}pages/{name}" title="{made.stem}" loading="lazy"></iframe>'
            link = f'<p><a href="{up}pages/{name}">{made.name} on a page of its own</a></p>'
            found.append(nodes.raw("", frame + link, format="html"))
        return found


class Shell(Run):
    """Commands of ``linkframe``, one a line, run."""

    language = "sh"

    def execute(self, code: str, page: str) -> None:
        """Run the commands in this process."""
        from linkframe.models.command_line import main

        for line in code.splitlines():
            name, *given = shlex.split(line)
            if name != "linkframe" or main(given):
                raise self.error(f"{page}: {line!r} is no command of linkframe, or ended with an error")


def setup(app):
    """Make the directives known to Sphinx."""
    app.add_directive("run", Run)
    app.add_directive("shell", Shell)
    return {"parallel_read_safe": False}
