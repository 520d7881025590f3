"""report.md of a job: what went in, what came out, how it looks, how long it took."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from .tables import spent

PAGE = """\
Open [{page}]({page}): drag the drive, and set the load, clearances and tolerances; path, worst case, deflection, forces
and the contributors follow."""


@dataclass(frozen=True)
class Report:
    """What a job reports, as paragraphs in Markdown.

    Attributes
    ----------
    title
        Heading.
    summary
        What came out in short.
    sections
        Inputs and tables, with their headings.
    paraview
        How to look at the ParaView files.
    more
        Sections behind the figures.
    """

    title: str
    summary: Sequence[str]
    sections: Sequence[str]
    paraview: str
    more: Sequence[str] = ()

    def text(
        self, pictures: Mapping[str, str], notes: Sequence[str], seconds: Mapping[str, float], page: str = ""
    ) -> str:
        """The whole report.

        Parameters
        ----------
        pictures
            Caption of each figure that was drawn, by file.
        notes
            What the reader should know of the run, such as what could not be drawn.
        seconds
            Time that each stage took.
        page
            File for a browser, where there is one.

        Returns
        -------
        str
            Markdown.
        """
        # A PDF cannot be shown in a page: it is linked to.
        figures = [
            f"{'' if file.endswith('.pdf') else '!'}[{text}]({file})\n\n{text}" for file, text in pictures.items()
        ]
        paragraphs = [
            f"# {self.title}",
            *self.summary,
            *(f"**Note:** {note}" for note in notes),
            *self.sections,
            *(["## Figures", *figures] if figures else []),
            *(["## In a browser", PAGE.format(page=page)] if page else []),
            "## In ParaView",
            self.paraview,
            *self.more,
            "## Time",
            spent(seconds),
        ]
        return "\n\n".join(paragraphs) + "\n"
