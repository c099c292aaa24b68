"""The penalty form of coupled rigid-block analysis, eq. 5.8, against a program written apart.

Kao and others 2022: of all forces in balance, within the friction of what presses, for which some
virtual motion has the overlap eps at every corner that presses and slides against the friction,
those with the least pull. The program here is solved as it stands, by sequential quadratic programs
of SciPy on the points, normals and masses of a model. Its conditions f (d + eps) = 0 and f+ f- = 0
are met up to a share that goes to zero.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from scipy.optimize import minimize

from drystone import Model, Verdict, models, solve_cra_penalty
from drystone.base.arrays import Floats
from drystone.models import overhang

SHARES = (1.0, 1e-2, 1e-8)
"""Of the weight times eps: to how much the conditions of contact are met, one after another."""


@dataclass(frozen=True)
class Program:
    """Eq. 5.8 in forces by the weight, and motion by the overlap eps.

    Attributes
    ----------
    normal : (6 b, k)
        Forces and moments on the free blocks of a unit of pressure at each corner.
    along : (6 b, 2 k)
        The same for the two directions of its plane.
    load : (6 b,)
    friction : (k,)
    """

    normal: Floats
    along: Floats
    load: Floats
    friction: Floats

    @classmethod
    def of(cls, model: Model) -> Program:
        contacts, assembly = model.contacts, model.assembly
        rows = {int(block): 6 * i for i, block in enumerate(assembly.free)}
        columns = np.zeros((6 * len(rows), contacts.corner_count, 3))
        for corner, interface in enumerate(contacts.interface):
            sides = ((contacts.block_a, -1.0), (contacts.block_b, 1.0))
            for block, sign in ((int(side[interface]), sign) for side, sign in sides):
                if block in rows:
                    force = sign * contacts.frame[interface].T
                    arm = contacts.point[corner] - assembly.centroid[block]
                    at = rows[block]
                    columns[at : at + 3, corner] = force
                    columns[at + 3 : at + 6, corner] = np.cross(arm, force.T).T
        load = model.load.wrench[assembly.free].ravel()
        return cls(
            columns[:, :, 0],
            columns[:, :, 1:].reshape(len(columns), -1),
            load / np.abs(load).max(),
            contacts.friction[contacts.interface],
        )

    def solve(self) -> tuple[Floats, Floats]:
        """Pressure and pull of each corner (k,), by the largest load of a block."""
        rows, corners = self.normal.shape
        ends = np.cumsum([corners, corners, 2 * corners, rows, corners])
        press, pull, shear, motion, alpha = map(slice, [0, *ends[:-1]], ends)
        every = np.arange(corners)

        balance = np.zeros((rows, ends[-1]))
        balance[:, press], balance[:, pull], balance[:, shear] = (
            self.normal,
            -self.normal,
            self.along,
        )
        octagon = np.pi / 4.0 * np.arange(8)
        within = np.zeros((8, corners, ends[-1]))
        within[:, every, every] = self.friction
        within[:, every, shear.start + 2 * every] = -np.cos(octagon)[:, None]
        within[:, every, shear.start + 2 * every + 1] = -np.sin(octagon)[:, None]
        within = within.reshape(-1, ends[-1])
        opening = np.zeros((corners, ends[-1]))
        opening[:, motion] = self.normal.T

        weights = np.zeros(ends[-1])
        weights[pull], weights[press], weights[alpha] = 1.0, 1e-6, 1e-6

        def against(x: Floats) -> Floats:
            return x[shear] + np.repeat(x[alpha], 2) * (self.along.T @ x[motion])

        def against_slope(x: Floats) -> Floats:
            slope = np.zeros((2 * corners, ends[-1]))
            slope[:, shear] = np.eye(2 * corners)
            slope[:, motion] = np.repeat(x[alpha], 2)[:, None] * self.along.T
            slope[np.arange(2 * corners), alpha.start + np.repeat(every, 2)] = (
                self.along.T @ x[motion]
            )
            return slope

        def contact(x: Floats) -> Floats:
            return np.concatenate([-x[press] * (opening @ x + 1.0), -x[press] * x[pull]])

        def contact_slope(x: Floats) -> Floats:
            slope = np.zeros((2, corners, ends[-1]))
            slope[0] = -x[press][:, None] * opening
            slope[0, every, every] -= opening @ x + 1.0
            slope[1, every, every] = -x[pull]
            slope[1, every, corners + every] = -x[press]
            return slope.reshape(-1, ends[-1])

        x = np.zeros(ends[-1])
        x[press], x[pull], x[alpha] = 0.3, 0.1, 0.1
        x[motion] = np.random.default_rng(0).normal(0.0, 0.3, rows)
        signed = [(0.0, None)] * (2 * corners)
        bounds = [*signed, *[(None, None)] * (2 * corners + rows), *signed[:corners]]
        for share in SHARES:
            constraints = [
                {"type": "eq", "fun": lambda x: balance @ x + self.load, "jac": lambda _: balance},
                {"type": "eq", "fun": against, "jac": against_slope},
                {"type": "ineq", "fun": lambda x: within @ x, "jac": lambda _: within},
                {"type": "ineq", "fun": lambda x: opening @ x + 1.0, "jac": lambda _: opening},
                {"type": "ineq", "fun": lambda x, s=share: contact(x) + s, "jac": contact_slope},
            ]
            found = minimize(
                lambda x: weights @ x**2,
                x,
                jac=lambda x: 2.0 * weights * x,
                constraints=constraints,
                bounds=bounds,
                method="SLSQP",
                options={"maxiter": 200, "ftol": 1e-12},
            )
            x = found.x
        assert found.success, found.message
        return x[press], x[pull]


def stepped(*shifts: float) -> Model:
    return Model.of(overhang(shifts), friction=0.8)


@pytest.mark.parametrize(
    ("model", "joints", "needy"),
    [
        (stepped(0.6), {("brick-00", "brick-01")}, {"brick-01"}),
        (stepped(0.9), {("brick-00", "brick-01")}, {"brick-01"}),
        (stepped(0.55, 0.02), {("brick-00", "brick-01")}, {"brick-01", "brick-02"}),
        (stepped(0.2, 0.55), {("brick-01", "brick-02")}, {"brick-02"}),
        (
            Model.of(models.a_model(), friction=0.6),
            {("left", "block"), ("right", "block")},
            {"block"},
        ),
    ],
    ids=["overhang", "far", "lower joint", "upper joint", "a"],
)
def test_the_pull_and_where_it_is_needed_are_those_of_eq_58(
    model: Model, joints: set[tuple[str, str]], needy: set[str]
) -> None:
    """Pulls of all corners agree to 5e-4 of the largest load of a block."""
    pull = Program.of(model).solve()[1]
    found = solve_cra_penalty(model)
    assert found.verdict is Verdict.UNSTABLE
    assert found.tension is not None
    largest = np.abs(model.load.wrench[model.assembly.free]).max()
    assert found.tension / largest == pytest.approx(pull, abs=5e-4)
    contacts, names = model.contacts, model.assembly.names
    at = contacts.interface[pull > 1e-3]
    assert {frozenset((names[contacts.block_a[i]], names[contacts.block_b[i]])) for i in at} == {
        frozenset(joint) for joint in joints
    }
    assert set(found.falling_names) == needy


def test_eq_58_holds_by_tension_what_slides_without_opening_a_joint_and_ours_does_not() -> None:
    model = Model.of(models.two_blocks_on_incline(40.0), friction=0.3)
    press, pull = Program.of(model).solve()
    assert pull.sum() > 1.0
    # pulls let other corners press as much as friction needs; the sum is what the slope carries
    assert (press - pull).sum() == pytest.approx(np.cos(np.radians(40.0)), rel=1e-6)
    found = solve_cra_penalty(model)
    assert found.tension == pytest.approx(0.0)
    assert found.falling_names == ("upper",)


def test_where_eq_58_needs_no_pull_nothing_needs_help() -> None:
    model = stepped(0.4)
    press, pull = Program.of(model).solve()
    assert pull == pytest.approx(0.0, abs=1e-6)
    assert press.sum() == pytest.approx(1.0)
    found = solve_cra_penalty(model)
    assert found.stable
    assert not found.falling_names
