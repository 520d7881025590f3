"""What is computed once does not make others wait."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from threading import Barrier

from linkframe.framework.lazily import cached_property


def test_objects_of_a_class_compute_at_the_same_time() -> None:
    """Each waits inside for the other."""
    both = Barrier(2)

    class Counted:
        times = 0

        @cached_property
        def value(self) -> int:
            both.wait(timeout=5.0)
            self.times += 1
            return self.times

    one, other = Counted(), Counted()
    with ThreadPoolExecutor(2) as pool:
        assert list(pool.map(lambda each: each.value, (one, other))) == [1, 1]
    assert one.value == other.value == 1
    assert one.times == other.times == 1
