"""Many settlements at once."""

import numpy as np
import pytest

from drystone import InputError, LoadCase, Model
from drystone.models import arch, incline, tower, wedge
from drystone.settlement import Loading, SettlementOptions, settle, settle_many

X = (1.0, 0.0, 0.0)


def wedges(tilts: tuple[float, ...]) -> list[Model]:
    model = Model.of(wedge("b"), friction=0.84)
    return [model.with_load(LoadCase.tilt(model.assembly, X, tilt)) for tilt in tilts]


def test_each_model_settles_as_it_does_alone() -> None:
    """Wedges that rest, jam, and fall, among models of other shapes and one without free blocks."""
    fixed = incline(10.0).with_fixed([0, 1])
    steep = Model.of(incline(40.0), friction=0.5)
    others = [Model.of(tower(2), friction=0.6), Model.of(fixed, friction=0.6), steep]
    models = [*others[:2], *wedges((20.0, 50.0, 59.0)), *others[2:]]
    found = settle_many(models)
    assert len(found) == len(models)
    for model, together in zip(models, found, strict=True):
        alone = settle(model)
        assert together.outcome is alone.outcome
        assert together.message == alone.message
        for one, other in zip(together.paths, alone.paths, strict=True):
            assert (one.carrier, one.steps) == (other.carrier, other.steps)
            np.testing.assert_allclose(one.displacement, other.displacement, atol=1e-9)
            np.testing.assert_allclose(
                one.force, other.force, atol=1e-5 * np.abs(other.force).max()
            )


def test_several_free_blocks_and_an_order_of_loading_change_nothing() -> None:
    bow, slope = arch(0.2, 3), incline(0.0)
    bows = [LoadCase.tilt(bow, (0.0, 1.0, 0.0), tilt) for tilt in (2.0, 30.0)]
    slopes = [LoadCase.tilt(slope, (0.0, 1.0, 0.0), tilt) for tilt in (10.0, 30.0)]
    for assembly, loads, order in ((bow, bows, Loading.AT_ONCE), (slope, slopes, Loading.RAMP)):
        models = [Model.of(assembly, friction=0.4, load=load) for load in loads]
        options = SettlementOptions(loading=order)
        for model, together in zip(models, settle_many(models, options=options), strict=True):
            alone = settle(model, options=options)
            assert together.outcome is alone.outcome
            assert together.travel == pytest.approx(alone.travel, rel=1e-6)


def test_it_stops_and_tells_progress() -> None:
    told: list[tuple[int, int]] = []
    models = wedges((20.0, 50.0, 56.0, 70.0))
    found = settle_many(
        models, time_limit_s=1e-9, progress=lambda stage, done, total: told.append((done, total))
    )
    assert told == [(1, 4), (2, 4), (3, 4), (4, 4)]
    assert all("time" in one.stopped for one in found)
    assert settle_many([]) == ()


def test_a_single_model_is_refused() -> None:
    for one in (wedges((20.0,))[0], 5):
        with pytest.raises(InputError, match="give a list of models"):
            settle_many(one)  # type: ignore[arg-type]
