"""``linkframe run``: the accuracy of the linkage that a file describes."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace, RawDescriptionHelpFormatter
from pathlib import Path
from typing import TYPE_CHECKING

from ....framework.garbage import lasting
from ...job import run
from ...job.output import add_output
from ...job.overrides import add_tolerance
from ...job.sharing import add_sharing, sharing
from ...sampling import SAMPLERS
from . import inputs as job_inputs
from . import run as linkage_run

if TYPE_CHECKING:
    from argparse import _SubParsersAction

DESCRIPTION = """\
Where the points of a linkage really go: rigid motion, reactions, compliance of links and joints, joint clearance, and
the spread of all of it under tolerances, at every pose. The linkage and what to do with it are read from a TOML file
(its tables of points, links, joints, ... are described at linkframe.models.read_linkage), SI units. A joint with a
clearance takes its contact angle from the file (contact = 3.14 in [joints.B], radians from global x, and tolerances of
joints.B.contact); without one the contact is found by equilibrium under the load:

  [run]
  points = ["P"]                      points to report; those with a load by default
  pose = 30.0                         pose of the figures, a value of the first drive
  magnify = 20.0                      factor on the drawn displacements
  branch = "keep"                     or "switch" at change points
  tolerance = 0.0                     a gap up to this counts as closed, for drawings with few digits
  samples = 100                       with tolerances
  rng = 0                             seed; the same seed gives the same bits
  sampler = "random"                  or "sobol", "halton", "lhs"
  nan_policy = "omit"                 samples without a result do not count; or "propagate": they leave their pose
                                      without statistics; "raise": they end the run
  also = ["condition", "digits"]      further tables: condition numbers; certain digits; "large", large displacement
                                      of all samples, each of which takes as long as hundreds by linear mechanics

  [run.drives.A]                      one table for each driven joint; [run.drives.A.uz] where several coordinates are
  start = 0.0
  stop = 360.0
  steps = 37                          number of poses; or values = [...]
  unit = "deg"                        or "rad", the default
  rate = 0.0                          by time, in that unit, or one a pose; with rates the links' inertia acts
  acceleration = 0.0

  [tolerances.gap]                    any name
  of = ["joints.B.clearance"]         numbers of this file that share one draw
  distribution = "norm"               a distribution of scipy.stats, and its numbers
  loc = 1e-3                          about the number that the file has
  scale = 5e-5

  [choices."the other side in the plane"]   any name: numbers of this file set otherwise, in a line of its own
  "sections.flat.y" = 0.00635

  [measured]                          positions of a point that were measured, beside those predicted
  file = "measured.csv"               columns x, y, z, ux, uy, uz (standard uncertainty), and of each drive, such as
                                      "A [deg]" or "A [rad]"; without these measured at the poses
                                      of the run
  point = "P"                         the first point to report by default
  level = 0.95                        probability with which a pose should lie within its band

  [tolerances]
  "points.P.x" = "± 1e-4"             a single number by its name; also "± 5 %", "+2e-5/-1e-5", "± 5 % normal"

  [tolerances.springs]
  of = ["joints.B.stiffness"]         all finite numbers of a list but 0, or one: joints.B.stiffness.ux, points.B.y
  distribution = "norm"
  scale = "5 %"                       loc and scale in percent: deviation, as a share of each number"""

WRITES = """\
writes into DIR: table.csv, reactions.csv, measured.csv (with measured positions), samples.npz (with tolerances),
trajectory.pvd with its .vtu files, report.md; with --figures 2d index.html, which opens in a browser, mechanism.png,
trajectory.png, reactions.png, histogram.png (with tolerances), measured.png (with measured positions), and with
--figures all figure3d.png as well (with beams, where rendering works); with --format svg pdf those but figure3d as
such"""


def add_to(jobs: _SubParsersAction[ArgumentParser]) -> None:
    """Add the subcommand ``run`` to the jobs of the command line."""
    parser = jobs.add_parser(
        "run",
        help="accuracy of the linkage in a file at every pose",
        description=DESCRIPTION,
        epilog=WRITES,
        formatter_class=RawDescriptionHelpFormatter,
    )
    parser.add_argument("file", type=Path, metavar="FILE", help="TOML file with the linkage")
    parser.add_argument(
        "--sampler", choices=SAMPLERS, help="how samples are drawn, in place of what the file says (else: random)"
    )
    parser.add_argument(
        "--measured", type=Path, metavar="CSV", help="table of measured positions, in place of that of the file"
    )
    add_tolerance(
        parser,
        "tolerance of a number of the file by its name, such as joints.B.clearance, or of what a tolerance of the file "
        "varies by its name",
    )
    add_sharing(parser)
    add_output(parser, None, " (default: results-NAME for NAME.toml)")
    parser.set_defaults(run=_start)


def _start(options: Namespace) -> None:
    out = options.out or Path(f"results-{options.file.stem}")
    with lasting(alone=options.alone):
        inputs = _inputs(options)
        job = linkage_run.LinkageJob(inputs, sharing(options, inputs))
    run.run(job, out, options.figures, options.format, options.wide, options.begun)


def _inputs(options: Namespace) -> job_inputs.RunInputs:
    """Inputs of the file, as the options change them."""
    given = (options.tolerance,) if options.tolerance else ()
    inputs = job_inputs.read_inputs(options.file, *given)
    if options.sampler is not None:
        inputs = inputs.drawn_by(options.sampler)
    if options.measured is not None:
        inputs = inputs.measured_by(options.measured)
    return inputs
