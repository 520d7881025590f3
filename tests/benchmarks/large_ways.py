"""One large frame, solved in one way in a process of its own: seconds by stage, peak memory and errors."""

from __future__ import annotations

import gc
import json
import os
import sys
from collections.abc import Callable, Iterator
from time import process_time
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # the benchmarks run on one core; more threads would wait for it
os.environ.setdefault("MKL_NUM_THREADS", "1")

import numpy as np
from linkframe.elements import Beam, Material, Section
from linkframe.framework import Frame, clock
from linkframe.framework.batched.plan import Plan
from linkframe.framework.solvers.iterative import Iterative
from linkframe.framework.solvers.sparse import SparseSolver
from numpy.typing import NDArray
from scipy.linalg import solveh_banded
from scipy.sparse import csr_matrix, diags, tril, triu
from scipy.sparse.csgraph import reverse_cuthill_mckee
from scipy.sparse.linalg import cg, splu

from .harness import peak_memory

Array = NDArray[Any]
Size = tuple[int, int, int]
Seconds = dict[str, float]

# A section 0.1 m by 0.2 m of steel; members 1 m long.
AREA, IY, IZ, TORSION, E, G = 0.02, 0.1 * 0.2**3 / 12.0, 0.2 * 0.1**3 / 12.0, 4.57e-5, 200e9, 80e9
LOAD = (1e3, 5e2, -2e3)
# Beams up to which the error is measured, by refinement in extended precision.
SMALL = 2000
# Runs, of which the fastest counts, of what takes less than so many seconds.
RUNS, SHORT = 3, 1.0


def places(size: Size) -> Iterator[tuple[int, int, int]]:
    """Nodes, storey by storey."""
    nx, ny, nz = size
    return ((i, j, k) for k in range(nz) for j in range(ny) for i in range(nx))


def members(size: Size) -> Iterator[tuple[int, tuple[int, int, int], tuple[int, int, int]]]:
    """Direction and ends of the beams along x, y, z between neighbours."""
    for place in places(size):
        for axis in range(3):
            if place[axis] + 1 < size[axis]:
                i, j, k = place
                yield axis, place, (i + (axis == 0), j + (axis == 1), k + (axis == 2))


def described(size: Size) -> Frame:
    """The frame, held at its foot and pushed at its top."""
    frame, beam = Frame(), Beam(Section(A=AREA, Iy=IY, Iz=IZ, J=TORSION), Material(E=E, G=G))
    name = {place: f"{place}" for place in places(size)}
    for place in name:
        frame.node(name[place], place)
    for axis, start, end in members(size):
        frame.add(f"{start}{'xyz'[axis]}", beam, name[start], name[end])
    for i, j, k in name:
        if k == 0:
            frame.fix(name[i, j, k])
        if k == size[2] - 1:
            frame.load(name[i, j, k], fx=LOAD[0], fy=LOAD[1], fz=LOAD[2])
    return frame


# -- linkframe --------------------------------------------------------------------------------------------------------


def linkframe(size: Size, method: str, *, plain: bool) -> tuple[Seconds, Array, str, float]:
    """Seconds by stage, displacements (n,), the method, and its operations; `plain` hides the extra ``fast``."""
    clock.perf_counter = process_time  # type: ignore[attr-defined]
    if plain:
        from linkframe.framework.solvers import method as ways

        ways.find_spec = lambda name: None  # type: ignore[assignment]
    tip = f"{tuple(n - 1 for n in size)}"
    described((3, 3, 3)).solve(method or "sparse").displacement("(2, 2, 2)")
    start = process_time()
    frame = described(size)
    middle = process_time()
    solution = frame.solve(method or None)
    solution.displacement(tip)
    total = process_time() - middle
    times = solution.plan.times
    solved = times["factorisation"] + times["solution"]
    seconds = {"description": middle - start, "numbering": times["numbering"], "assembly": times["assembly"]}
    seconds |= {"solution": solved, "rest": total - solved - times["numbering"] - times["assembly"], "total": total}
    assert isinstance(solution.solver, SparseSolver)
    name = solution.plan.method.name
    return seconds, solution.solver.unknowns[:, 0], name, operations(solution.solver, name)


def operations(solver: SparseSolver, method: str) -> float:
    """Multiplications and additions of a factor, or of the products with the matrix in an iteration."""
    graph = solver.plan.graph
    if isinstance(solver.factor, Iterative):
        return 2.0 * solver.factor.iterations * float(solver.stiffness.nnz)
    return len(solver.unknown) * float(graph.width) ** 2 if method == "banded" else graph.dissection.operations


# -- raw solvers, given the matrix ------------------------------------------------------------------------------------


def superlu(matrix: csr_matrix, load: Array) -> Array:
    """SuperLU in symmetric mode."""
    options = {"SymmetricMode": True}
    return splu(matrix.tocsc(), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=options).solve(load)


def superlu_default(matrix: csr_matrix, load: Array) -> Array:
    """SuperLU as scipy calls it by default."""
    return splu(matrix.tocsc()).solve(load)


def banded(matrix: csr_matrix, load: Array) -> Array:
    """LAPACK's banded Cholesky in reverse Cuthill-McKee order."""
    order = reverse_cuthill_mckee(matrix, symmetric_mode=True)
    entries = tril(matrix[order][:, order], format="coo")
    below = entries.row - entries.col
    band = np.zeros((below.max() + 1, len(load)), order="F")
    band[below, entries.col] = entries.data
    found = np.empty_like(load)
    found[order] = solveh_banded(band, load[order], overwrite_ab=True, lower=True, check_finite=False)
    return found


def cholmod(matrix: csr_matrix, load: Array) -> Array:
    """CHOLMOD in its own choice of order."""
    from cvxopt import cholmod as library
    from cvxopt import matrix as dense
    from cvxopt import spmatrix

    lower = tril(matrix, format="csc")
    columns = np.repeat(np.arange(lower.shape[1]), np.diff(lower.indptr))
    places = dense(lower.indices.astype(np.int64)), dense(columns.astype(np.int64))
    entries = spmatrix(dense(lower.data), *places, lower.shape)
    factor = library.symbolic(entries)
    library.numeric(entries, factor)
    right = dense(load)
    library.solve(factor, right)
    return np.array(right).reshape(-1)


def pardiso(matrix: csr_matrix, load: Array) -> Array:
    """MKL's PARDISO for positive definite matrices."""
    from pypardiso import PyPardisoSolver

    upper, solver = triu(matrix, format="csr"), PyPardisoSolver(mtype=2)
    solver.factorize(upper)
    return np.asarray(solver.solve(upper, load)).reshape(-1)


def gradients(matrix: csr_matrix, load: Array) -> Array:
    """scipy's conjugate gradients, diagonally scaled, to a residual at rounding."""
    root = 1.0 / np.sqrt(matrix.diagonal())
    scaled, right = csr_matrix(diags(root) @ matrix @ diags(root)), root * load
    found, _ = cg(scaled, right, rtol=1e-13, maxiter=20_000)
    return root * found


RAW: dict[str, Callable[[csr_matrix, Array], Array]] = {
    "superlu": superlu,
    "superlu_default": superlu_default,
    "banded": banded,
    "cholmod": cholmod,
    "pardiso": pardiso,
    "gradients": gradients,
}


def raw(size: Size, name: str) -> tuple[Seconds, Array, str]:
    """Seconds of a solver alone on linkframe's matrix."""
    matrix, load = system(size)
    small = system((3, 3, 3))
    RAW[name](*small)
    start = process_time()
    found = RAW[name](matrix, load)
    total = process_time() - start
    return {"solution": total, "total": total}, found, name


# -- openseespy -------------------------------------------------------------------------------------------------------


def opensees(size: Size, numberer: str, solver: str) -> tuple[Seconds, Array, str]:
    """Seconds of openseespy, and displacements of the nodes that are free."""
    import openseespy.opensees as ops

    start = process_time()
    tag = {place: number for number, place in enumerate(places(size), start=1)}
    ops.wipe()
    ops.model("basic", "-ndm", 3, "-ndf", 6)
    for place, number in tag.items():
        ops.node(number, *map(float, place))
    for place, number in tag.items():
        if place[2] == 0:
            ops.fix(number, *[1] * 6)
    ops.geomTransf("Linear", 1, 0.0, 0.0, 1.0)
    ops.geomTransf("Linear", 2, 1.0, 0.0, 0.0)
    for number, (axis, first, last) in enumerate(members(size), start=1):
        values = (AREA, E, G, TORSION, IY, IZ)
        ops.element("elasticBeamColumn", number, tag[first], tag[last], *values, 2 if axis == 2 else 1)
    ops.timeSeries("Linear", 1)
    ops.pattern("Plain", 1, 1)
    for place, number in tag.items():
        if place[2] == size[2] - 1:
            ops.load(number, *LOAD, 0.0, 0.0, 0.0)
    middle = process_time()
    ops.constraints("Plain")
    ops.numberer(numberer)
    ops.system(solver)
    ops.algorithm("Linear")
    ops.integrator("LoadControl", 1.0)
    ops.analysis("Static")
    if ops.analyze(1) != 0:
        raise RuntimeError(f"openseespy's {solver} failed")
    total = process_time() - middle
    found = np.array([ops.nodeDisp(number) for place, number in tag.items() if place[2]]).reshape(-1)
    return {"description": middle - start, "total": total}, found, f"{numberer} {solver}"


# -- errors -----------------------------------------------------------------------------------------------------------


def system(size: Size) -> tuple[csr_matrix, Array]:
    """Matrix and load; the unknowns are the displacements of the nodes above the foot, storey by storey."""
    plan = Plan(described(size))
    solver = SparseSolver(plan)
    return solver.stiffness, solver.load[:, 0]


def residual(matrix: csr_matrix, load: Array, found: Array) -> float:
    """Backward error: unbalanced force relative to what matrix and load are made of."""
    root = 1.0 / np.sqrt(matrix.diagonal())
    norm = float((diags(root) @ abs(matrix) @ root).max())
    left = np.linalg.norm(root * (load - matrix @ found))
    return float(left / (norm * np.linalg.norm(found / root) + np.linalg.norm(root * load)))


def truth(size: Size, matrix: csr_matrix, load: Array) -> Array:
    """Displacements by iterative refinement; residuals from the members' stiffness in extended precision."""
    plan = Plan(described(size))
    first = 6 * size[0] * size[1]
    factor = splu(matrix.tocsc(), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    found = np.zeros(len(load) + first, dtype=np.longdouble)
    stacks = [(group.dofs, group.extended_stiffness()) for group in plan.topology.groups]
    for _ in range(12):
        inner = np.zeros_like(found)
        for dofs, stiffness in stacks:
            np.add.at(inner, dofs, np.einsum("nij,nj->ni", stiffness, found[dofs]))
        step = factor.solve((load - inner[first:]).astype(float))
        found[first:] += step
        if np.abs(step).max() < 1e-19 * np.abs(found).max():
            break
    return found[first:]


def measure(kind: str, *arguments: str) -> dict[str, Any]:
    """Run one way; see `large_frames`."""
    size: Size = tuple(json.loads(arguments[0]))

    def once() -> tuple[Seconds, Array, str, *tuple[float, ...]]:
        gc.collect()  # lest a run pays for memory that the one before still holds
        if kind == "opensees":
            return opensees(size, *arguments[1:])
        if kind == "raw":
            return raw(size, *arguments[1:])
        return linkframe(size, arguments[1], plain=kind == "plain")

    runs = [once()]
    memory = peak_memory()
    while runs[0][0]["total"] < SHORT and len(runs) < RUNS:
        runs.append(once())
    seconds, found, told, *count = min(runs, key=lambda run: run[0]["total"])
    matrix, load = system(size)
    out = {"told": told, "MB": memory / 1e6, "residual": residual(matrix, load, found)} | seconds
    out |= {"operations": count[0]} if count else {}
    if sum(1 for _ in members(size)) <= SMALL:
        exact = truth(size, matrix, load)
        out["error"] = float(np.abs(found - exact).max() / np.abs(exact).max())
    return out


if __name__ == "__main__":
    print(json.dumps(measure(*sys.argv[1:])))
