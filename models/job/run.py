"""A job of the command line: it is computed completely and then written, all of its files or none."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Protocol

import numpy as np

from ...framework.errors import expected_mechanisms
from .beside import Beside
from .letters import missing_letters
from .measured import FIGURE_FILE, TABLE_FILE, MeasuredOutcome
from .output import results, terminal_width, written
from .rendered import picture
from .report import Report
from .stages import Advance, Stages
from .tables import folded

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from ...framework.solution import Solution

# Compression level of zlib for figures: files up to a third larger than by default, in a fifth of the time.
FAST = 1
# File name of the page for a browser.
PAGE = "index.html"
# Options that keep the date out of a file.
UNDATED: Mapping[str, Any] = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}


class JobResult(Protocol):
    """The part of a job's result that all jobs have."""

    @property
    def measured(self) -> MeasuredOutcome | None:
        """Measured positions compared with predicted ones; None without measurements."""

    @property
    def solution(self) -> Solution:
        """Solution of the frame that is shown in space."""


class Job(ABC):
    """Base class of jobs, which `run` runs.

    Attributes
    ----------
    name
        Name of the subcommand.
    optional
        Patterns of files that not every run writes; those of an earlier run that this run does not write are removed.
    result
        Numbers of the job.
    """

    name: ClassVar[str]
    optional: ClassVar[tuple[str, ...]]
    result: JobResult

    @property
    @abstractmethod
    def has_beams(self) -> bool:
        """Whether a link has a beam, to be shown in space."""

    @property
    @abstractmethod
    def work(self) -> Mapping[str, int]:
        """Amount of work, by part."""

    @abstractmethod
    def compute(self, advance: Advance) -> None:
        """Compute all that can fail; `advance` is called with the progress."""

    @property
    @abstractmethod
    def entry(self) -> int:
        """Number of the pose that is shown."""

    @abstractmethod
    def tables(self) -> Mapping[str, str]:
        """Text files by name."""

    @abstractmethod
    def samples(self) -> Mapping[str, NDArray[Any]]:
        """Arrays of ``samples.npz``; empty without samples."""

    @abstractmethod
    def figures(self) -> Iterator[tuple[str, Figure]]:
        """Figures by the names of their files."""

    @abstractmethod
    def captions(self) -> Mapping[str, str]:
        """Captions of the figures and of the picture in space, by file."""

    @abstractmethod
    def page(self, path: Path) -> None:
        """Write the page for a browser."""

    @abstractmethod
    def save(self, path: Path) -> None:
        """Write the ParaView files, which need no samples."""

    def compared(self) -> object:
        """Results that the report compares the job with, picklable and computed without the job's samples."""
        return None

    @abstractmethod
    def report(self, compared: Any = None) -> Report:
        """Report without figures, notes and times; `compared` is the result of that method if it is known already."""

    @abstractmethod
    def remarks(self) -> list[str]:
        """Remarks that a reader should know before using the numbers."""

    @abstractmethod
    def summary(self, width: int | None = None) -> str:
        """Table and explanations for a terminal of the given width."""


def run(
    job: Job,
    out: Path,
    figures: str = "all",
    formats: Sequence[str] = ("png",),
    wide: bool = False,
    begun: float | None = None,
) -> None:
    """Run a job and print its table.

    Parameters
    ----------
    job
        The job.
    out
        Directory for the results; made if it does not exist. Files of an earlier run are replaced, others stay.
    figures
        Figures to draw: ``"none"``, ``"2d"`` with the page for a browser, or ``"all"`` with the picture in space too.
    formats
        Formats of the figures in the plane, such as ``"svg"``; the picture in space is a PNG.
    wide
        Whether the table is printed in one piece, however wide the terminal is.
    begun
        Start of the program on the clock of `time.perf_counter`, if the reported times should include its start.

    Raises
    ------
    FrameError
        If something cannot be computed, or `out` cannot be written or has the results of another job; then nothing is
        written.
    """
    space, plane = figures == "all" and job.has_beams, figures != "none"
    with (
        results(out, job.name, (*job.optional, PAGE)) as stage,
        expected_mechanisms(),
        Beside(partial(_without_samples, job, stage), worth=bool(job.work)) as other,
        picture(space) as drawn,
    ):
        stages, boxes = Stages(4 + space + 2 * plane, begun), list[str]()
        with stages("solution", job.work) as advance:
            job.compute(advance)
        if space:
            drawn.begin(job.result.solution, stage / "figure3d.png", job.entry)
        with stages("tables and samples"):
            for name, text in job.tables().items():
                (stage / name).write_text(text, encoding="utf-8")
            if job.result.measured is not None:
                (stage / TABLE_FILE).write_text(job.result.measured.as_csv(), encoding="utf-8")
            samples: Mapping[str, Any] = job.samples()
            if samples:
                np.savez_compressed(stage / "samples.npz", **samples)
        if plane:
            with stages("figures"), missing_letters() as boxes:
                for name, figure in job.figures():
                    _write(figure, stage / name, formats)
                if job.result.measured is not None:
                    _write(job.result.measured.draw(), stage / FIGURE_FILE, formats)
            with stages("page"):
                job.page(stage / PAGE)
        with stages("ParaView files"):
            compared = other.outcome()
        notes: list[str] = []
        if space:
            with stages("3-D picture"):
                notes = drawn.wait()
        with stages("report"):
            notes = [*job.remarks(), *boxes, *notes]
            pictures, report = dict(_pictures(stage, job.captions(), formats)), job.report(compared)
        text = report.text(pictures, notes, stages.seconds, PAGE if plane else "")
        (stage / "report.md").write_text(text, encoding="utf-8")
        stages.close()
        files = written(stage)
    width = terminal_width()
    measured = [] if job.result.measured is None else [job.result.measured.in_words()]
    print(folded("\n\n".join([job.summary(None if wide else width), *measured, *notes]), width))
    listed = folded(f"Written to {out}: {', '.join(files)}", width)
    print(f"\n{listed}\n{folded(stages.spent, width)}")


def _without_samples(job: Job, folder: Path) -> object:
    """Work that needs no samples, and is done while these are computed."""
    job.save(folder / "trajectory.pvd")
    return job.compared()


def _write(figure: Figure, path: Path, formats: Sequence[str]) -> None:
    """Write a figure in some formats; the text of an SVG stays text."""
    from matplotlib import rc_context

    for form in dict.fromkeys(formats):
        # without dates and with fixed identifiers, so that two runs of the same inputs write the same bytes
        with (
            rc_context({"svg.fonttype": "none", "svg.hashsalt": path.stem, "pdf.fonttype": 42}),
            _laid_out(figure, form),
        ):
            text: dict[str, Any] = {"pil_kwargs": {"compress_level": FAST}} if form == "png" else {}
            figure.savefig(path.with_suffix(f".{form}"), metadata=UNDATED.get(form), **text)


@contextmanager
def _laid_out(figure: Figure, form: str) -> Iterator[None]:
    """Compute the layout of a PNG now, as savefig would draw the whole figure once more to find it.

    Other formats measure texts differently, and compute their own layout.
    """
    layout = figure.get_layout_engine()
    if form != "png" or layout is None:
        yield
        return
    layout.execute(figure)
    figure.set_layout_engine(None)
    try:
        yield
    finally:
        figure.set_layout_engine(layout)


def _pictures(folder: Path, captions: Mapping[str, str], formats: Sequence[str]) -> Iterator[tuple[str, str]]:
    """Files that a report can show, with their captions; a PDF only if there is no other format."""
    forms = sorted({*formats, "png"}, key=lambda form: (form == "pdf", formats.index(form) if form in formats else 99))
    for name, text in captions.items():
        found = (path.name for form in forms if (path := (folder / name).with_suffix(f".{form}")).exists())
        if file := next(found, None):
            yield file, text
