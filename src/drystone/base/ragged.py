"""Rows that belong to owners: the corners of interfaces, the faces of blocks, pieces of faces."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sized
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drystone.base.arrays import Bools, Floats, Ints, frozen, frozen_ints
from drystone.base.display import OneLine
from drystone.base.errors import InputError, counted

BATCH = 1_000_000
"""Rows of arrays that are made at once. Chosen: bounds the memory to some 100 MB."""


@dataclass(frozen=True, eq=False)
class Ragged(OneLine):
    """Rows that are stored in the order of their owners. An owner may have no row.

    It holds no values: every method takes an array with one value (or vector) per row or per owner.

    Parameters
    ----------
    start : (n + 1,)
        Owner i has the rows ``start[i]`` to ``start[i + 1] - 1``. It begins with 0.

    Raises
    ------
    InputError
        ``start`` is empty, does not begin with 0, or descends.

    Examples
    --------
    >>> rows = Ragged.from_counts([2, 0, 3])
    >>> rows
    Ragged(3 owners, 5 rows)
    >>> rows.owner.tolist()
    [0, 0, 2, 2, 2]
    >>> rows.sum(np.array([1.0, 2.0, 3.0, 4.0, 5.0])).tolist()
    [3.0, 0.0, 12.0]
    >>> part, row = rows.take([2, 0])
    >>> part.counts.tolist(), row.tolist()
    ([3, 2], [2, 3, 4, 0, 1])
    """

    start: Ints

    def __post_init__(self) -> None:
        start = frozen_ints(self.start, (None,), "start")
        if len(start) == 0 or start[0] != 0 or (start[1:] < start[:-1]).any():
            raise InputError("start must begin with 0 and ascend")
        object.__setattr__(self, "start", start)

    @classmethod
    def over(cls, start: Ints | Ragged) -> Ragged:
        """Rows by the ``start`` of their owners, or as they are."""
        return start if isinstance(start, Ragged) else cls(start)

    @classmethod
    def from_counts(cls, counts: Iterable[int] | Ints) -> Ragged:
        """The same number of rows for each owner."""
        number = counts if isinstance(counts, np.ndarray) else list(counts)
        start = np.zeros(len(number) + 1, dtype=np.intp)
        np.cumsum(number, out=start[1:])
        return cls(frozen(start))

    @classmethod
    def from_owners(cls, owner: Ints, count: int) -> Ragged:
        """The owner (l,) of each row, ascending, of ``count`` owners."""
        return cls(np.searchsorted(owner, np.arange(count + 1)).astype(np.intp))

    @classmethod
    def of(cls, lists: Iterable[Sized]) -> Ragged:
        """One owner per list, one row per item of it."""
        return cls.from_counts([len(each) for each in lists])

    def _summary(self) -> str:
        return f"{counted(len(self), 'owner')}, {counted(self.rows, 'row')}"

    def __len__(self) -> int:
        """Number of owners, n."""
        return len(self.start) - 1

    def __getitem__(self, owner: int) -> slice:
        """The rows of one owner; negative positions count from the end."""
        if not -len(self) <= owner < len(self):
            raise IndexError(f"owner {owner} of {len(self)}")
        i = owner % len(self)
        return slice(int(self.start[i]), int(self.start[i + 1]))

    def __iter__(self) -> Iterator[slice]:
        return (self[i] for i in range(len(self)))

    @cached_property
    def rows(self) -> int:
        """Number of rows, l."""
        return int(self.start[-1])

    @property
    def first(self) -> Ints:
        """(n,) the first row of each owner; that of the next one where it has none."""
        return self.start[:-1]

    @cached_property
    def counts(self) -> Ints:
        """(n,) number of rows of each owner."""
        return frozen(self.start[1:] - self.start[:-1])

    @cached_property
    def owner(self) -> Ints:
        """(l,) the owner of each row."""
        return frozen(np.repeat(np.arange(len(self), dtype=np.intp), self.counts))

    @cached_property
    def following(self) -> Ints:
        """(l,) the next row of the same owner; after the last its first, as in a polygon."""
        after = np.arange(1, self.rows + 1)
        filled = slice(None) if self._filled is None else self._filled
        after[self.start[1:][filled] - 1] = self.first[filled]
        return frozen(after)

    def split(self, values: NDArray[Any]) -> list[NDArray[Any]]:
        """The values (l, ...) of each owner, as views."""
        return [values[part] for part in self]

    def spread(self, values: NDArray[Any]) -> NDArray[Any]:
        """The value (n, ...) of its owner, for each row."""
        return values[self.owner]

    def sum(self, values: NDArray[Any]) -> NDArray[Any]:
        """Sum (n, ...) of the values (l, ...) of each owner; 0 where it has no row.

        Truth values are counted.
        """
        number = values.astype(np.intp) if values.dtype == bool else values
        return self._reduced(np.add, number, 0)

    def mean(self, values: Floats) -> Floats:
        """Mean (n, ...) of the values (l, ...) of each owner; NaN where it has no row."""
        count = self.counts.reshape(-1, *(1,) * (values.ndim - 1))
        with np.errstate(invalid="ignore"):
            mean: Floats = self.sum(values) / count
        return mean

    def min(self, values: NDArray[Any], empty: Any = np.inf) -> NDArray[Any]:
        """Least of the values (l, ...) of each owner; ``empty`` where it has no row."""
        return self._reduced(np.minimum, values, empty)

    def max(self, values: NDArray[Any], empty: Any = -np.inf) -> NDArray[Any]:
        """Largest of the values (l, ...) of each owner; ``empty`` where it has no row."""
        return self._reduced(np.maximum, values, empty)

    def argmax(self, values: NDArray[Any]) -> Ints:
        """(n,) the first row with the largest of the values (l,) of each owner, who has one."""
        rows = np.flatnonzero(values >= self.max(values)[self.owner])
        return rows[np.searchsorted(self.owner[rows], np.arange(len(self)))]

    def any(self, values: Bools) -> Bools:
        """Whether a row of each owner is true; false where it has none."""
        return self._reduced(np.logical_or, values, False)

    def all(self, values: Bools) -> Bools:
        """Whether every row of each owner is true; true where it has none."""
        return self._reduced(np.logical_and, values, True)

    def take(self, owners: Any) -> tuple[Ragged, Ints]:
        """Some owners in the given order; an owner may occur several times.

        Parameters
        ----------
        owners : (t,) positions, or a mask (n,)

        Returns
        -------
        part
            Their rows, one after another.
        row : (part.rows,)
            Where each of them was.
        """
        chosen = np.asarray(owners)
        chosen = np.flatnonzero(chosen) if chosen.dtype == bool else chosen.astype(np.intp)
        count = self.counts[chosen]
        part = Ragged.from_counts(count)
        return part, np.repeat(self.first[chosen] - part.first, count) + np.arange(part.rows)

    def keep(self, rows: Bools) -> Ragged:
        """Only some rows (l,) of the same owners."""
        return Ragged.from_counts(self.sum(rows))

    def batches(self, most: int) -> Iterator[Ints]:
        """Positions of owners, in runs that have about ``most`` rows together, or one owner."""
        run = self.first // most
        yield from np.split(np.arange(len(self)), np.flatnonzero(np.diff(run)) + 1)

    @cached_property
    def _filled(self) -> Bools | None:
        """(n,) which owners have a row; None where there are owners and all have one."""
        filled: Bools = self.counts > 0
        return None if len(self) and filled.all() else frozen(filled)

    def _reduced(self, how: np.ufunc, values: NDArray[Any], empty: Any) -> NDArray[Any]:
        """``how`` over the rows of each owner; numpy takes no owner without a row."""
        if len(values) != self.rows:
            raise InputError(f"{len(values)} values for {counted(self.rows, 'row')}")
        filled = self._filled
        if filled is None:
            return how.reduceat(values, self.first, axis=0)
        result = np.full((len(self), *values.shape[1:]), empty, dtype=values.dtype)
        if filled.any():
            result[filled] = how.reduceat(values, self.first[filled], axis=0)
        return result


def expand(first: Ints, count: Ints) -> tuple[Ints, Ints]:
    """All numbers of several ranges, and the range that each comes from.

    Parameters
    ----------
    first, count : (r,)
        Range i is ``first[i]`` to ``first[i] + count[i] - 1``.

    Returns
    -------
    source, value : (total,)

    Examples
    --------
    >>> source, value = expand(np.array([5, 0]), np.array([2, 3]))
    >>> source.tolist(), value.tolist()
    ([0, 0, 1, 1, 1], [5, 6, 0, 1, 2])
    """
    source = np.repeat(np.arange(len(count), dtype=np.intp), count)
    before = np.cumsum(count) - count
    value = np.arange(len(source), dtype=np.intp) + (first - before)[source]
    return source, value.astype(np.intp)


def linked(one: Ints, other: Ints, count: int) -> Ints:
    """Group (count,) of each of ``count`` items, where those of each pair (p,) belong together.

    Examples
    --------
    >>> linked(np.array([0, 3]), np.array([2, 2]), 4).tolist()
    [0, 1, 0, 0]
    """
    if count + len(one) <= 100:  # measured: 27 to 75 us, where a sparse matrix takes 190
        first = [*range(count)]
        for i, j in zip(one.tolist(), other.tolist(), strict=True):
            low, high = sorted((first[i], first[j]))
            first = [low if k == high else k for k in first] if low < high else first
        return np.unique(first, return_inverse=True)[1]
    from scipy.sparse import coo_array  # slow to import, and few models need it
    from scipy.sparse.csgraph import connected_components

    graph = coo_array((np.ones(len(one)), (one, other)), shape=(count, count))
    return connected_components(graph, directed=False)[1].astype(np.intp)


def first_linked(one: Ints, other: Ints, count: int) -> Ints:
    """The first (count,) of the items that each of ``count`` is linked with, by pairs (p,).

    Examples
    --------
    >>> first_linked(np.array([0, 3]), np.array([2, 2]), 4).tolist()
    [0, 1, 0, 0]
    """
    group = linked(one, other, count)
    return np.unique(group, return_index=True)[1][group]


def sum_by_owner(values: Floats, owner: Ints, count: int) -> Floats:
    """Sums (count, d) of the rows (r, d) of each of ``count`` owners (r,), in any order."""
    columns = [np.bincount(owner, column, minlength=count) for column in values.T]
    return np.stack(columns, axis=1).astype(np.float64)


def runs_by_length(first: Ints, total: int) -> list[tuple[Ints, Ints]]:
    """Runs of rows by their length c: numbers (r,) of the runs, and their rows (r c,).

    Parameters
    ----------
    first
        Row at which each run begins, ascending.
    total
        Number of rows.

    Examples
    --------
    >>> [(run.tolist(), row.tolist()) for run, row in runs_by_length(np.array([0, 2, 3]), 5)]
    [([1], [2]), ([0, 2], [0, 1, 3, 4])]
    """
    count = np.diff(np.append(first, total))
    found = []
    for length in np.unique(count):
        runs = np.flatnonzero(count == length)
        found.append((runs, (first[runs, None] + np.arange(length)).ravel()))
    return found
