"""Films: the stages of an answer, with the place of each in its chart."""

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from drystone import FormatError, InputError, Model, check, plan
from drystone.limits import LimitOptions, limit_train
from drystone.models import segmental_bridge, tower
from drystone.view import save_film


def test_the_axles_of_a_train_move_over_the_bridge_from_place_to_place() -> None:
    bridge = Model.of(segmental_bridge(voussoirs=6), friction=0.6)
    found = limit_train(bridge, steps=2, options=LimitOptions(equilibrium_only=True))
    placed = [one for one in found.layers().stages if one.spot]
    known = list(zip(found.places, found.factors, strict=True))
    assert [one.spot for one in placed] == known
    for one in placed:
        assert one.spot is not None
        axles = next(layer for layer in one.layers if layer.key == "axles")
        assert axles.position[:, 0] == pytest.approx(one.spot[:1])
    assert found.axles(0)["x"] == pytest.approx(found.places[:1])


def test_a_plan_is_written_as_a_film_of_its_steps(tmp_path: Path) -> None:
    save_film(plan(Model.of(tower(3), friction=0.6)), tmp_path / "plan.gif")
    with Image.open(tmp_path / "plan.gif") as film:
        assert film.n_frames >= 2
        first = np.array(film.convert("RGB"))
        film.seek(film.n_frames - 1)
        assert (np.array(film.convert("RGB")) != first).any()


def test_what_is_no_film_is_refused(tmp_path: Path) -> None:
    found = check(tower(2), friction=0.6)
    with pytest.raises(InputError, match="one stage is no film; write a figure, --png"):
        save_film(found, tmp_path / "check.gif")
    with pytest.raises(FormatError, match=r"this is no name of a film; end it in \.gif"):
        save_film(found, tmp_path / "check.mp4")
