"""A job of the command line: computed whole, then written, everything or nothing."""

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

# Level at which zlib packs the pixels of figures: up to a third larger than usual, in a fifth of the time.
FAST = 1
# The page that opens in a browser.
PAGE = "index.html"
# What keeps the date out of a file.
UNDATED: Mapping[str, Any] = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}


class JobResult(Protocol):
    """What the result of any job has."""

    @property
    def measured(self) -> MeasuredOutcome | None:
        """What was measured beside what is predicted, with a table, a figure and words of its own; None for nothing."""

    @property
    def solution(self) -> Solution:
        """The frame that is shown in space."""


class Job(ABC):
    """What a job computes and writes; `run` runs it.

    Attributes
    ----------
    name
        Its subcommand.
    optional
        Patterns of files that a run may leave and another may not; those that this one does not write are removed.
    result
        What it computes.
    """

    name: ClassVar[str]
    optional: ClassVar[tuple[str, ...]]
    result: JobResult

    @property
    @abstractmethod
    def has_beams(self) -> bool:
        """Whether there is a beam to show in space."""

    @property
    @abstractmethod
    def work(self) -> Mapping[str, int]:
        """How much there is of each thing to compute."""

    @abstractmethod
    def compute(self, advance: Advance) -> None:
        """Compute all that can fail; `advance` is told how far it is."""

    @property
    @abstractmethod
    def entry(self) -> int:
        """Which of its poses is shown."""

    @abstractmethod
    def tables(self) -> Mapping[str, str]:
        """Text files by name."""

    @abstractmethod
    def samples(self) -> Mapping[str, NDArray[Any]]:
        """What ``samples.npz`` holds; nothing where there are no samples."""

    @abstractmethod
    def figures(self) -> Iterator[tuple[str, Figure]]:
        """Figures by the names of their files."""

    @abstractmethod
    def captions(self) -> Mapping[str, str]:
        """Captions of the figures and of the picture in space, by file."""

    @abstractmethod
    def page(self, path: Path) -> None:
        """Write the page that opens in a browser."""

    @abstractmethod
    def save(self, path: Path) -> None:
        """Write the ParaView files, which take no samples."""

    def compared(self) -> object:
        """What the report compares the job with, which takes none of its samples; it can be pickled."""
        return None

    @abstractmethod
    def report(self, compared: Any = None) -> Report:
        """What ``report.md`` holds beside figures, notes and times; `compared` is what the method of that name gives,
        where it is known already."""

    @abstractmethod
    def remarks(self) -> list[str]:
        """What the reader of the numbers should know before using them."""

    @abstractmethod
    def summary(self, width: int | None = None) -> str:
        """What a terminal of that width shows: the table, and what explains it."""


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
        What to compute.
    out
        Directory for the results; made if it does not exist. Files of an earlier run are replaced, others stay.
    figures
        Which are drawn: ``"none"``, ``"2d"`` and the page for a browser, or with the picture in space ``"all"``.
    formats
        Forms of the figures in the plane, such as ``"svg"``; the picture in space is a PNG.
    wide
        Whether the table is printed in one piece, however wide the terminal is.
    begun
        When the program began, on the clock of `time.perf_counter`, if its start is to count in the times told.

    Raises
    ------
    FrameError
        If something cannot be computed, or `out` cannot be written or holds the results of another job; then nothing
        is written.
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
    """What needs none of the samples, and is done while they are computed."""
    job.save(folder / "trajectory.pvd")
    return job.compared()


def _write(figure: Figure, path: Path, formats: Sequence[str]) -> None:
    """Write a figure in some forms; the text of an SVG stays text."""
    from matplotlib import rc_context

    for form in dict.fromkeys(formats):
        # Two runs of the same inputs write the same bytes: without dates, and with the same names inside.
        with (
            rc_context({"svg.fonttype": "none", "svg.hashsalt": path.stem, "pdf.fonttype": 42}),
            _laid_out(figure, form),
        ):
            text: dict[str, Any] = {"pil_kwargs": {"compress_level": FAST}} if form == "png" else {}
            figure.savefig(path.with_suffix(f".{form}"), metadata=UNDATED.get(form), **text)


@contextmanager
def _laid_out(figure: Figure, form: str) -> Iterator[None]:
    """Find the layout of a PNG at once: to have it found, savefig would draw everything once more, on nothing.

    The other forms measure texts otherwise, and find their own.
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
    """Files that a report can show, with their captions; a PDF stands as a link where there is nothing else."""
    forms = sorted({*formats, "png"}, key=lambda form: (form == "pdf", formats.index(form) if form in formats else 99))
    for name, text in captions.items():
        found = (path.name for form in forms if (path := (folder / name).with_suffix(f".{form}")).exists())
        if file := next(found, None):
            yield file, text
