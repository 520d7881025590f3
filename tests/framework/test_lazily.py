"""What is computed once does not make others wait, and is one object for all who ask."""

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


def test_one_object_for_two_threads() -> None:
    """Both compute it; what each is given, and what is kept, is that of one of them."""
    both = Barrier(2)

    class Owner:
        @cached_property
        def value(self) -> object:
            both.wait(timeout=5.0)
            return object()

    owner = Owner()
    with ThreadPoolExecutor(2) as pool:
        first, second = pool.map(lambda _: owner.value, range(2))
    assert first is second is owner.value


def test_found_by_name_and_left_alone_where_it_is_set() -> None:
    """It is an attribute of the object like any other: a subclass may override it, a copy may set it, or drop it."""

    class Owner:
        @cached_property
        def value(self) -> int:
            """What it is."""
            return 1

    class Other(Owner):
        @cached_property
        def value(self) -> int:
            return 1 + Owner.value.__get__(object.__new__(Owner))

    assert Owner.value.__doc__ == "What it is."
    assert Other().value == 2
    given = Owner()
    vars(given)["value"] = 3
    assert given.value == 3
    del given.value
    assert given.value == 1
