"""Spanning forests of what is joined: as scipy's, the first edges where there is a choice, as near to the ground as can
be."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from linkframe.framework.structure.forest import rooted, spanning
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import breadth_first_order, minimum_spanning_tree, shortest_path


@dataclass(frozen=True)
class Bar:
    """Between two nodes."""

    first: int
    second: int


def test_forests_of_random_graphs_are_those_of_scipy() -> None:
    rng = np.random.default_rng(3)
    for count, size in ((4, 6), (9, 20), (12, 9), (1, 5)):
        bars = [Bar(*rng.choice(count + 1, 2, replace=False).tolist()) for _ in range(size)]
        chosen, closing = spanning(bars)
        assert sorted([*map(bars.index, chosen), *map(bars.index, closing)]) == sorted(map(bars.index, bars))
        weight: dict[tuple[int, int], float] = {}  # scipy adds weights of edges that are given twice
        for k, bar in enumerate(bars):
            weight.setdefault((min(bar.first, bar.second), max(bar.first, bar.second)), k + 1.0)
        ends = np.array(list(weight))
        graph = coo_matrix((list(weight.values()), ends.T), (count + 1, count + 1)).tocsr()
        least = minimum_spanning_tree(graph)
        assert sum(bars.index(bar) + 1.0 for bar in chosen) == least.sum()
        self_rooted = rooted(bars, 0)
        assert len(self_rooted) == len(chosen)
        depth = {0: 0}
        for branch in self_rooted:
            depth[branch.child] = depth.get(branch.parent, 0) + 1
            ends_of = branch.edge.first, branch.edge.second
            assert ends_of == ((branch.child, branch.parent) if branch.is_reversed else (branch.parent, branch.child))
        near = shortest_path(graph, directed=False, unweighted=True, indices=0)
        reached = breadth_first_order(graph, 0, directed=False, return_predecessors=False)
        assert all(depth[node] == near[node] for node in reached.tolist())
