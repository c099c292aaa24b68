"""A sparse matrix put together from blocks at once: programs of changing size, built often."""

from __future__ import annotations

import numpy as np
from scipy import sparse

from drystone.arrays import Floats, Ints


class Triplets:
    """Entries of a sparse matrix, collected block by block; entries at one place add up.

    Parameters
    ----------
    rows, columns
        Shape of the matrix.

    Examples
    --------
    >>> matrix = Triplets(2, 3)
    >>> matrix.diagonal(0, 1, np.array([5.0, 6.0]))
    >>> matrix.csc().toarray()
    array([[0., 5., 0.],
           [0., 0., 6.]])
    """

    def __init__(self, rows: int, columns: int) -> None:
        self.shape = rows, columns
        self._row: list[Ints] = []
        self._column: list[Ints] = []
        self._value: list[Floats] = []

    def add(self, row: Ints, column: Ints, value: Floats) -> None:
        """Entries (m,) at the given places."""
        self._row.append(row)
        self._column.append(column)
        self._value.append(value)

    def diagonal(self, row: int, column: int, value: Floats) -> None:
        """A diagonal block whose first entry is at ``row``, ``column``."""
        place = np.arange(len(value))
        self.add(row + place, column + place, value)

    def csc(self) -> sparse.csc_matrix:
        """The matrix."""
        if not self._value:
            return sparse.csc_matrix(self.shape)
        place = np.concatenate(self._row), np.concatenate(self._column)
        return sparse.csc_matrix((np.concatenate(self._value), place), shape=self.shape)
