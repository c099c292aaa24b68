import numpy as np
import pytest

from drystone import InputError
from drystone.shells import (
    Edge,
    Side,
    find_form,
    rectangular_plan,
    three_legged_plan,
)

SHELL = find_form(rectangular_plan(6.0, 5.0), height=1.8, thickness=0.2)
THREE = find_form(three_legged_plan(), height=2.5, thickness=0.2)


@pytest.mark.parametrize("form", [SHELL, THREE], ids=["one free edge", "three vaults"])
def test_every_bar_is_pressed_and_every_node_balanced(form):
    assert form.residual < 1e-8
    assert form.force.min() > 0.0


def test_the_height_is_the_one_asked_for():
    assert SHELL.height == pytest.approx(1.8, rel=1e-8)
    assert THREE.height == pytest.approx(2.5, rel=1e-8)


def test_reactions_carry_the_weight():
    """Half of a quadrilateral's weight at a fixed node goes to the ground without the net."""
    down = SHELL.reaction[:, 2].sum()
    area = _area(SHELL.shape.patches[0])
    assert down == pytest.approx(area * 0.2 * 2400.0 * 9.81, rel=0.01)


def _area(patch):
    grid = (np.arange(80) + 0.5) / 80
    u, v = patch.tangents(grid[:, None], grid[None, :])
    return float(np.linalg.norm(np.cross(u, v), axis=2).sum() / 80**2)


def test_a_barrel_becomes_a_catenary():
    """Far from its ends a long vault is a hanging chain turned over."""
    plan = rectangular_plan(40.0, 4.0, open_sides=())
    form = find_form(plan, height=1.0, thickness=0.1, columns=161)
    middle = form.shape.patches[0].point(np.linspace(0.0, 1.0, 25), 0.5)
    y, z = middle[:, 1] - 2.0, middle[:, 2]
    a = _catenary_parameter(2.0, 1.0)
    expected = 1.0 - a * (np.cosh(y / a) - 1.0)
    assert np.abs(z - expected).max() < 1e-3


def _catenary_parameter(half_span, rise):
    from scipy.optimize import brentq

    return brentq(lambda a: a * (np.cosh(half_span / a) - 1.0) - rise, 0.5, 50.0)


def test_supports_keep_their_place_and_the_free_edge_moves_in():
    patch = SHELL.shape.patches[0]
    s = np.linspace(0.0, 1.0, 5)
    assert np.allclose(patch.border(Side.BOTTOM, s)[:, 1:], 0.0, atol=1e-9)
    assert patch.point(1.0, 0.5)[1] < 4.9


def test_a_stiffer_edge_stays_straighter():
    stiff = find_form(rectangular_plan(6.0, 5.0), height=1.8, edge_density=40.0)
    assert stiff.shape.patches[0].point(1.0, 0.5)[1] > SHELL.shape.patches[0].point(1.0, 0.5)[1]


def test_the_three_vaults_look_alike_from_each_leg():
    turn = 2.0 * np.pi / 3.0
    rotation = np.array(
        [[np.cos(turn), -np.sin(turn), 0.0], [np.sin(turn), np.cos(turn), 0.0], [0.0, 0.0, 1.0]]
    )
    u, v = np.meshgrid(np.linspace(0, 1, 5), np.linspace(0, 1, 5), indexing="ij")
    first, second = (THREE.shape.patches[k].point(u, v) for k in (0, 1))
    assert np.allclose(first @ rotation.T, second, atol=1e-9)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"height": 0.0}, "height is 0"),
        ({"height": 1.0, "thickness": -1.0}, "thickness is -1"),
        ({"height": 1.0, "rows": 3}, "rows is 3"),
    ],
)
def test_impossible_forms_are_refused(arguments, message):
    with pytest.raises(InputError, match=message):
        find_form(rectangular_plan(2.0, 2.0), **arguments)


def test_a_plan_without_a_support_is_refused():
    with pytest.raises(InputError, match="no support"):
        find_form(rectangular_plan(2.0, 2.0, open_sides=tuple(Side)), height=1.0)


def test_a_corner_of_the_plan_needs_a_column_of_the_net():
    with pytest.raises(InputError, match="odd number of columns"):
        find_form(three_legged_plan(), height=1.0, columns=24)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"density": 0.0}, "density is 0"),
        ({"density": float("nan")}, "density is nan"),
        ({"edge_density": -1.0}, "edge_density is -1"),
        ({"columns": 9.5}, "columns is 9.5; give a whole number"),
    ],
)
def test_a_net_has_densities_above_zero_and_enough_nodes(given, words):
    with pytest.raises(InputError, match=words):
        find_form(rectangular_plan(2.0, 2.0), height=1.0, **given)


def test_a_plan_held_on_one_side_carries_no_net():
    plan = rectangular_plan(6.0, 5.0).supported_on(Edge(0, Side.BOTTOM))
    with pytest.raises(InputError, match="supports lie on one line"):
        find_form(plan, height=1.8)
