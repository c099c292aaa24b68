"""Conic programs from named variables and rows."""

import numpy as np
import pytest
from scipy import sparse

from drystone.solvers.program import ConicStatus, ProgramBuilder


def test_equalities_come_first_then_inequalities_then_cones_whatever_the_order() -> None:
    program = ProgramBuilder()
    x = program.variable("x", 3)
    program.cone("norm", 3, np.array([1.0, 0.0, 0.0]), (x, -1.0))
    program.at_most("bound", np.full(3, 5.0), (x, 1.0))
    program.equal("sum", np.array([2.0]), (x, sparse.csr_matrix(np.ones((1, 3)))))
    made = program.build()
    assert made.rows == {"sum": slice(0, 1), "bound": slice(1, 4), "norm": slice(4, 7)}
    assert (made.cones.zero, made.cones.nonnegative, made.cones.second_order) == (1, 3, (3,))
    assert made.right.tolist() == [2.0, 5.0, 5.0, 5.0, 1.0, 0.0, 0.0]
    assert made.matrix.toarray()[made.rows["norm"]].tolist() == (-np.eye(3)).tolist()


def test_a_number_a_vector_and_a_matrix_are_the_same_coefficient() -> None:
    found = []
    for coefficient in (2.0, np.full(2, 2.0), sparse.identity(2) * 2.0):
        program = ProgramBuilder()
        program.variable("before", 1)
        x = program.variable("x", 2)
        program.at_most("bound", np.ones(2), (x, coefficient))
        found.append(program.build().matrix.toarray().tolist())
    assert found[0] == found[1] == found[2] == [[0.0, 2.0, 0.0], [0.0, 0.0, 2.0]]


def test_terms_of_one_variable_add_up() -> None:
    program = ProgramBuilder()
    x = program.variable("x", 1)
    program.equal("row", np.zeros(1), (x, 1.0), (x, 2.0))
    assert program.build().matrix.toarray().tolist() == [[3.0]]


def test_costs_and_units_belong_to_their_variable() -> None:
    program = ProgramBuilder()
    program.variable("free", 2)
    program.variable("costly", 1, linear=3.0, quadratic=4.0, unit=10.0)
    made = program.build()
    assert made.linear.tolist() == [0.0, 0.0, 3.0]
    assert made.quadratic.tolist() == [0.0, 0.0, 4.0]
    assert made.value(np.array([1.0, 2.0, 3.0]), "costly").tolist() == [30.0]
    assert made.value(np.array([1.0, 2.0, 3.0]), "free").tolist() == [1.0, 2.0]


def test_the_point_of_a_disc_nearest_to_another_point() -> None:
    # minimise |x - (3, 4)|^2 within |x| <= 1
    program = ProgramBuilder()
    x = program.variable("x", 2, linear=np.array([-3.0, -4.0]), quadratic=1.0)
    rows = sparse.csr_matrix([[0.0, 0.0], [-1.0, 0.0], [0.0, -1.0]])
    program.cone("disc", 3, np.array([1.0, 0.0, 0.0]), (x, rows))
    found = program.build().solve()
    assert found.status is ConicStatus.SOLVED
    assert found.x == pytest.approx([0.6, 0.8], abs=1e-7)


def test_a_program_without_rows_is_a_program() -> None:
    program = ProgramBuilder()
    program.variable("x", 2, linear=-1.0, quadratic=1.0)
    assert program.build().solve().x == pytest.approx([1.0, 1.0])
    assert program.build().matrix.shape == (0, 2)
