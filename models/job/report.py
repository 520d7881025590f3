"""``report.md`` of a job: inputs, results, figures and times."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from .tables import spent

PAGE = """\
Open [{page}]({page}): drag the drive, and set the load, clearances and tolerances; path, worst case, deflection, forces
and the contributors follow."""


@dataclass(frozen=True)
class Report:
    """Report of a job, as paragraphs in Markdown.

    Attributes
    ----------
    title
        Heading.
    summary
        Results in short.
    sections
        Inputs and tables, with their headings.
    paraview
        How to view the files in ParaView.
    more
        Sections after the figures.
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
            Notes for the reader, such as on a picture that could not be drawn.
        seconds
            Time of each stage, seconds.
        page
            File for a browser; empty if there is none.

        Returns
        -------
        str
            Markdown.
        """
        # Markdown cannot show a PDF, which is linked instead
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
