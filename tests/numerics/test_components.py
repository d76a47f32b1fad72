"""Parts of a graph that hang together."""

from __future__ import annotations

import numpy as np
import pytest
import scipy

from kinemark.numerics.components import components


@pytest.mark.parametrize("seed", range(200))
def test_parts_are_those_of_scipy_named_by_their_least_node(seed: int) -> None:
    rng = np.random.default_rng(seed)
    n, edges = rng.integers(1, 60), rng.integers(0, 60)
    a, b = rng.integers(0, n, (2, edges))
    graph = scipy.sparse.coo_array((np.ones(edges), (a, b)), shape=(n, n))
    part = scipy.sparse.csgraph.connected_components(graph, directed=False)[1]
    assert components(a, b, n).tolist() == [np.flatnonzero(part == part[k])[0] for k in range(n)]


def test_a_long_chain_in_any_order_is_one_part() -> None:
    order = np.random.default_rng(1).permutation(20_000)
    assert not components(order[:-1], order[1:], len(order)).any()
