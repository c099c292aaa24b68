"""Options are declared once: their documentation gives text, unit, range, type and default."""

from dataclasses import dataclass, field
from enum import Enum
from typing import Literal

import pytest

import drystone
from drystone import InputError
from drystone.base.declared import declared, declared_at, made_of
from drystone.base.settings import Options
from drystone.design import DesignMargin, MendOptions, RecutOptions
from drystone.limits import LimitOptions


class Finish(Enum):
    """Of a face."""

    ROUGH = "rough"
    AT_ONCE = "at once"


@dataclass(frozen=True)
class Dressing(Options):
    """How a stone is dressed.

    Attributes
    ----------
    depth : [m] > 0
        Whether to cut ``deeper``. In Python also negative.
    finish
        See nothing.
    friction : coefficient >= 0
        Of the face.
    tools
        Names.
    """

    depth: float = 0.02
    finish: Finish = Finish.ROUGH
    friction: float | None = None
    tools: tuple[str, ...] = ()
    margin: DesignMargin = field(default_factory=DesignMargin)
    side: Literal["left", "right"] = "left"


def test_text_unit_and_default_are_those_of_the_documentation() -> None:
    depth = declared(Dressing)["depth"]
    assert depth.told() == "Cut deeper (0.02 m)."
    assert (depth.unit, depth.ends) == ("m", {">": 0.0})
    assert declared(Dressing)["finish"].choices == ("rough", "at-once")


@pytest.mark.parametrize(
    ("name", "given", "value"),
    [
        ("depth", "20mm", 0.02),
        ("depth", 1, 1.0),
        ("finish", "at-once", Finish.AT_ONCE),
        ("friction", "45deg", pytest.approx(1.0)),
        ("friction", None, None),
        ("tools", ["pick", "axe"], ("pick", "axe")),
        ("margin", ["tilt=2deg"], DesignMargin(tilt=2.0)),
        ("side", "right", "right"),
    ],
)
def test_texts_and_values_of_json_are_read_by_type_and_unit(
    name: str, given: object, value: object
) -> None:
    assert declared(Dressing)[name].value(given) == value


@pytest.mark.parametrize(
    ("name", "given", "words"),
    [
        ("depth", 0.0, "give a number above zero"),
        ("depth", "deep", "is not a number with a unit"),
        ("friction", "-1", "zero or more"),
        ("finish", "smooth", "use one of rough, at once"),
        ("tools", 7, "give a list"),
        ("side", True, "use one of left, right"),
    ],
)
def test_what_an_option_cannot_be_is_refused_by_its_name(
    name: str, given: object, words: str
) -> None:
    with pytest.raises(InputError, match=words) as caught:
        declared(Dressing)[name].value(given)
    assert caught.value.where


def test_options_inside_options_are_reached_and_made_by_their_path() -> None:
    assert declared_at(RecutOptions, "plan.rules.hands").default == 2
    made = made_of(RecutOptions, {"most": 3, "plan.rules.hands": 4})
    assert (made.most, made.plan.rules.hands) == (3, 4)


def test_the_schema_has_the_types_and_the_range() -> None:
    known = declared(LimitOptions)
    assert known["width"].schema["exclusiveMinimum"] == 0.0
    assert known["scan"].schema["type"] == "integer"
    assert declared(MendOptions)["keep"].schema["type"] == "array"
    assert {"enum": ["mm", "cm", "m", "in", "ft"]}.items() <= (
        declared(drystone.read)["units"].schema.items()
    )


@pytest.mark.parametrize("of", [drystone.read, LimitOptions, MendOptions, RecutOptions])
def test_every_option_of_a_door_is_documented(of: object) -> None:
    known = declared(of)  # type: ignore[arg-type]
    assert [name for name, one in known.items() if not one.text and name != "progress"] == []
