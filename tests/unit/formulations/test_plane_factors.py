"""The plane program of a bridge gives what that of all corners gives."""

from dataclasses import replace

import numpy as np
import pytest

from drystone import JointCapacity, Model
from drystone.formulations.corner_forces import FrictionCone
from drystone.formulations.equilibrium import LoadFactors, PlaneFactors
from drystone.loads import Fill
from drystone.mechanics.statics import build_statics
from drystone.models import segmental_bridge
from drystone.ties import with_resisting_fill

EXACT = FrictionCone.exact()


@pytest.mark.parametrize("tied", [False, True])
@pytest.mark.parametrize("strength", [np.inf, 3e5])
def test_the_plane_program_has_the_factor_and_the_mechanism_of_the_whole(
    strength: float, tied: bool
) -> None:
    model = Model.of(segmental_bridge(voussoirs=7), friction=0.6)
    if strength < np.inf:
        mortar = JointCapacity.of_stress(model.contacts, compression=strength)
        model = model.with_capacity(mortar)
    if tied:
        fill = Fill(cover=0.3, weight=2e4, k=0.3, passive=1.0).on(model.assembly)
        model = with_resisting_fill(model.with_load(model.load + fill))
    statics = build_statics(model)
    live = np.zeros(statics.load.shape)
    live[2, 2] = -10.0
    whole, plane = LoadFactors(statics, EXACT), PlaneFactors.of(statics, EXACT, None)
    assert isinstance(plane, PlaneFactors)
    one, other = whole(live), plane(live)
    assert other.factor == pytest.approx(one.factor, rel=2e-5)
    left = statics.load + other.factor * live
    pushed = (statics.matrix @ other.state.force.ravel()).reshape(-1, 6)
    assert np.abs(pushed + left).max() < 1e-6
    assert other.state.multiplier / np.abs(other.state.multiplier).max() == pytest.approx(
        one.state.multiplier / np.abs(one.state.multiplier).max(), abs=0.01
    )
    if strength < np.inf and not tied:
        assert one.factor < 0.9 * LoadFactors(replace(statics, crushing=None), EXACT)(live).factor
        return
    live[2, 1] = 1.0  # across the bridge: the whole program answers
    assert plane(live).factor == pytest.approx(LoadFactors(statics, EXACT)(live).factor, rel=1e-6)


def test_what_is_not_the_same_across_its_width_is_left_to_the_whole_program() -> None:
    model = Model.of(segmental_bridge(voussoirs=7), friction=0.6)
    turned = np.array([[0.8, -0.6, 0.0], [0.6, 0.8, 0.0], [0.0, 0.0, 1.0]])
    skew = Model.of(model.assembly.transformed(turned), friction=0.6)
    assert not isinstance(PlaneFactors.of(build_statics(skew), EXACT, None), PlaneFactors)
