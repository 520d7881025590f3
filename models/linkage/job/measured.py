"""Measured positions of a point beside what the job predicts for them, with the band of the tolerances."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Protocol, TypeVar

import numpy as np

from ....framework.batch import Array
from ....framework.errors import FrameError
from ...job.tables import markdown, readable, separated
from ...measured.comparison import Comparison, compare
from ...measured.table import Measured, read_measured
from ..files.source import Source, shown_value

if TYPE_CHECKING:
    from .computed import Computed
