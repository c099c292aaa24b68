import dataclasses
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from drystone import (
    Assembly,
    Contacts,
    FormatError,
    InputError,
    LoadCase,
    Model,
    Result,
    Verdict,
    io,
)
from drystone.assembly import replace_block
from drystone.models import arch, box, tower
from drystone.results import Residuals, Samples, Sensitivity


def cube(name: str = "a", x: float = 0.0, **more: Any) -> dict[str, Any]:
    block = box((1.0, 1.0, 1.0), (x, 0.0, 0.0))
    faces = [list(f) for f in block.faces]
    return {"name": name, "vertices": block.vertices.tolist(), "faces": faces, **more}


def load(tmp_path: Path, content: Any, **options: str) -> io.Contents:
    path = tmp_path / "model.json"
    path.write_text(content if isinstance(content, str) else json.dumps(content), encoding="utf-8")
    return io.read_file(path, **options)


def full_model() -> io.Contents:
    """A tower of three whose joints, loads and results hold awkward numbers."""
    third = 1.0 / 3.0
    blocks = tuple(
        replace_block(
            block.transformed(translation=(third, np.pi * 1e4, 1e-7)),
            density=2000.0 + i * third,
            metadata={"layer": "Krüge 壁", "tags": [1, None, {"a": third}]} if i else {},
        )
        for i, block in enumerate(tower(3).blocks)
    )
    assembly = Assembly(blocks, np.array([True, False, False]))
    square = np.array([[0.0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]]) * third
    frame = np.array([[0.0, 0, 1], [1, 0, 0], [0, 1, 0]])
    contacts = Contacts(
        np.array([0, 1]),
        np.array([1, 2]),
        np.stack([frame, frame]),
        np.array([third, 0.1 + 0.2]),
        np.array([0.6, 0.1]),
        np.concatenate([square, square + np.sqrt(2.0)]),
        np.repeat([0, 1], 4),
    )
    rng = np.random.default_rng(4)
    load = LoadCase(rng.normal(size=(3, 6)) * 1e-90, "tiny")
    result = Result(
        method="check",
        verdict=Verdict.UNSTABLE,
        model=Model(assembly, contacts, load),
        message="it falls: 'quoted', \"twice\"\n",
        force=rng.normal(size=(8, 3)),
        tension=rng.normal(size=8),
        displacement=rng.normal(size=(3, 6)) * 1e-17,
        mechanism=rng.normal(size=(3, 6)),
        prop=-0.0 * np.ones((3, 6)),
        falling=(1, 2),
        samples=Samples(7, 3),
        sensitive_to=(Sensitivity.JOINTS, Sensitivity.ENDS),
        residuals=Residuals(1e-17, 0.0, 5e-324, 1.7e308, 0.1),
        eta=1.0 / 3.0,
        tilt_margin=20.0 / 3.0,
        tilt_about="-y",
        friction_margin=2.0 / 3.0,
        options={"eta": 10.0},
        solver="newton 1",
        iterations=12,
        time_s={"solve": 0.1},
    )
    return io.Contents(assembly, contacts, (LoadCase.gravity(assembly), load), (result,))


def same(one: Any, other: Any) -> bool:
    """Equal to the last bit, the sign of zero included."""
    if isinstance(one, np.ndarray):
        return (
            one.dtype == other.dtype
            and one.shape == other.shape
            and (one.tobytes() == other.tobytes())
        )
    return bool(one == other)


def test_everything_of_a_model_comes_back_to_the_last_bit(tmp_path: Path) -> None:
    model = full_model()
    io.write(model, tmp_path / "model.json")
    again = io.read_file(tmp_path / "model.json")
    assert again.contacts is not None
    assert model.contacts is not None
    assert again.assembly.names == model.assembly.names
    assert same(again.assembly.fixed, model.assembly.fixed)
    for one, other in zip(model.assembly.blocks, again.assembly.blocks, strict=True):
        assert same(one.vertices, other.vertices)
        assert one.faces == other.faces
        assert one.density == other.density
        assert dict(one.metadata) == dict(other.metadata)
    for field in dataclasses.fields(Contacts):
        assert same(getattr(model.contacts, field.name), getattr(again.contacts, field.name))
    assert [load.name for load in again.loads] == ["gravity", "tiny"]
    for load, other_load in zip(model.loads, again.loads, strict=True):
        assert same(load.wrench, other_load.wrench)
    (result,), (other_result,) = model.results, again.results
    assert other_result.assembly is again.assembly
    assert other_result.contacts is again.contacts
    assert other_result.load is again.loads[1]
    for field in dataclasses.fields(Result):
        if field.name != "model":
            assert same(getattr(result, field.name), getattr(other_result, field.name)), field.name


def test_every_part_of_a_result_is_kept() -> None:
    from drystone.io.drystone_json import RESULT

    names = {field.name for field in dataclasses.fields(Result)} - {"model"}
    # blocks and contacts are given once, for all results; paths are not written
    assert names - {"settlement"} | {"load"} == set(RESULT)


def test_a_result_is_written_with_its_model(tmp_path: Path) -> None:
    result = full_model().results[0]
    io.write(result, tmp_path / "result.json")
    assert io.read_file(tmp_path / "result.json").results[0].verdict is Verdict.UNSTABLE


def test_a_result_of_another_model_is_not_written(tmp_path: Path) -> None:
    model = full_model()
    other = dataclasses.replace(model, assembly=tower(3))
    with pytest.raises(FormatError, match="another assembly"):
        io.write(other, tmp_path / "model.json")
    assert not list(tmp_path.iterdir())


def test_metadata_that_json_cannot_hold_is_refused(tmp_path: Path) -> None:
    block = replace_block(tower(1).blocks[0], metadata={"x": object()})
    with pytest.raises(FormatError, match="no JSON value"):
        io.write(Assembly((block,)), tmp_path / "model.json")
    assert not list(tmp_path.iterdir())


def test_options_are_written_as_plain_values(tmp_path: Path) -> None:
    @dataclasses.dataclass(frozen=True)
    class Options:
        verdict: Verdict = Verdict.STABLE
        limits: tuple[float, ...] = (1.0, 2.0)

    model = full_model()
    result = dataclasses.replace(model.results[0], options=Options())
    io.write(dataclasses.replace(model, results=(result,)), tmp_path / "model.json")
    options = io.read_file(tmp_path / "model.json").results[0].options
    assert options == {"verdict": "stable", "limits": [1.0, 2.0]}


def test_the_minimal_form_is_enough(tmp_path: Path) -> None:
    model = load(tmp_path, {"_about": "mine", "blocks": [cube(fixed=True), cube("b", 2.0)]})
    assert model.assembly.names == ("a", "b")
    assert model.assembly.fixed.tolist() == [True, False]
    assert model.contacts is None
    assert model.loads == model.results == model.notes == ()


def test_units_of_the_file_are_honoured_and_can_be_overruled(tmp_path: Path) -> None:
    content = {"units": "cm", "blocks": [cube()]}
    assert load(tmp_path, content).assembly.blocks[0].volume == pytest.approx(1e-6)
    model = load(tmp_path, content, units="in")
    assert model.assembly.blocks[0].volume == pytest.approx(0.0254**3)
    assert model.notes == ("lengths are read as in, as asked; the file says cm",)


def test_a_model_of_unlikely_size_is_remarked_upon(tmp_path: Path) -> None:
    big = box((2000.0, 300.0, 300.0))
    content = {"blocks": [cube() | {"vertices": big.vertices.tolist()}]}
    assert "no unit was given" in load(tmp_path, content).notes[0]
    assert load(tmp_path, content, units="mm").notes == ()


def changed(path: str, value: Any) -> dict[str, Any]:
    """Two cubes with one value changed; a path such as ``blocks.1.name``."""
    content: Any = {"schema": "drystone", "version": 1, "blocks": [cube("a"), cube("b", 2.0)]}
    at = content
    *steps, last = [int(s) if s.isdigit() else s for s in path.split(".")]
    for step in steps:
        at = at[step]
    if value is KeyError:
        del at[last]
    else:
        at[last] = value
    return dict(content)


NAN, INFINITY = float("nan"), float("inf")


@pytest.mark.parametrize(
    ("path", "value", "words"),
    [
        ("blocks.1.vertices.2.0", NAN, ["blocks[1].vertices[2][0]", "nan"]),
        ("blocks.1.vertices.2.0", INFINITY, ["blocks[1].vertices[2][0]", "inf"]),
        ("blocks.1.vertices.2.0", "1", ["blocks[1].vertices[2][0]", "must be a number"]),
        ("blocks.1.vertices.2.0", True, ["blocks[1].vertices[2][0]", "must be a number"]),
        ("blocks.1.vertices.2.0", 10**400, ["blocks[1].vertices[2][0]", "too large"]),
        ("blocks.1.vertices.2", [1.0, 2.0], ["blocks[1].vertices[2]", "2 items, not 3"]),
        ("blocks.1.vertices.2", None, ["blocks[1].vertices[2]", "null"]),
        ("blocks.1.vertices", {}, ["blocks[1].vertices", "a list", "an object"]),
        ("blocks.1.vertices", [], ["blocks[1].faces[0]", "is no vertex"]),
        ("blocks.1.vertices.2.0", 1e30, ["block 'b'", "1e+30 m"]),
        ("blocks.1.faces.3.1", 8, ["blocks[1].faces[3][1]", "8", "0 to 7"]),
        ("blocks.1.faces.3.1", -1, ["blocks[1].faces[3][1]", "-1"]),
        ("blocks.1.faces.3.1", 1.5, ["blocks[1].faces[3][1]", "whole number"]),
        ("blocks.1.faces.3", 7, ["blocks[1].faces[3]", "a list"]),
        ("blocks.1.name", 7, ["blocks[1].name", "a string", "number 7"]),
        ("blocks.1.name", "", ["blocks[1].name", "empty"]),
        ("blocks.1.name", KeyError, ["blocks[1]", "'name' is missing"]),
        ("blocks.1.faces", KeyError, ["blocks[1]", "'faces' is missing"]),
        ("blocks.1.name", "a", ["same name, 'a'", "blocks[0] and blocks[1]"]),
        ("blocks.1.fixed", 1, ["blocks[1].fixed", "true or false"]),
        ("blocks.1.density", -1, ["blocks[1].density", "-1"]),
        ("blocks.1.density", 1e300, ["blocks[1].density", "1e+300"]),
        ("blocks.1.colour", "red", ["blocks[1]", "unknown field 'colour'", "known are"]),
        ("blocks.1", [], ["blocks[1]", "an object"]),
        ("blocks", [], ["blocks", "holds no block"]),
        ("blocks", KeyError, ["has no 'blocks'", "minimal form"]),
        ("colour", 1, ["unknown field 'colour'"]),
        ("schema", "masonry", ["schema", "'drystone'"]),
        ("version", 2, ["version", "newer drystone"]),
        ("version", "1", ["version", "whole number"]),
        ("units", "yd", ["'yd'"]),
        ("results", [{}], ["results[0]", "no contacts"]),
        ("loads", [{"wrench": [[0] * 6]}], ["loads[0].wrench", "1 items, not 2"]),
    ],
)
def test_what_is_wrong_is_named_with_its_path(
    tmp_path: Path, path: str, value: Any, words: list[str]
) -> None:
    with pytest.raises(InputError) as caught:
        load(tmp_path, changed(path, value))
    assert "\n" not in str(caught.value)
    for word in words:
        assert word in str(caught.value)


@pytest.mark.parametrize(
    ("path", "value", "words"),
    [
        ("contacts.block_a.1", 3, ["contacts.block_a[1]", "3"]),
        ("contacts.block_b.0", 0, ["contacts", "two different blocks"]),
        ("contacts.frame.1.2.0", NAN, ["contacts.frame[1][2][0]", "nan"]),
        ("contacts.friction.1", -0.1, ["contacts", "friction is -0.1"]),
        ("contacts.interface.0", 1, ["contacts", "ascending"]),
        ("contacts.point", [], ["contacts", "differ in length"]),
        ("results.0.load", 2, ["results[0].load", "2"]),
        ("results.0.verdict", "maybe", ["results[0].verdict", "stable"]),
        ("results.0.force.7.2", "x", ["results[0].force[7][2]", "number"]),
        ("results.0.force", [[0, 0, 0]], ["results[0].force", "1 items, not 8"]),
        ("results.0.falling", [3], ["results[0].falling"]),
        ("units", "mm", ["units", "must be 'm'"]),
    ],
)
def test_what_is_wrong_with_contacts_loads_and_results_is_named(
    tmp_path: Path, path: str, value: Any, words: list[str]
) -> None:
    file = tmp_path / "model.json"
    io.write(full_model(), file)
    content = json.loads(file.read_text(encoding="utf-8"))
    at = content
    *steps, last = [int(s) if s.isdigit() else s for s in path.split(".")]
    for step in steps:
        at = at[step]
    at[last] = value
    with pytest.raises(FormatError) as caught:
        load(tmp_path, content)
    for word in words:
        assert word in str(caught.value)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ('{"blocks": [', ["ends too early", "line 1"]),
        ('{"blocks": [{"name": "vouss', ["ends too early", "export it again"]),
        ('{"blocks": [}', ["is not JSON", "line 1, column 13"]),
        ("[]", ["holds no block"]),
        ("[" * 100_000, ["nested too deeply"]),
        ('{"blocks": [], "blocks": []}', ["'blocks' is given twice"]),
        ("9" * 5000, ["no JSON that can be used"]),
        ("null", ["must be an object", "null"]),
    ],
)
def test_what_is_no_json_is_refused_in_one_line(
    tmp_path: Path, text: str, words: list[str]
) -> None:
    with pytest.raises(FormatError) as caught:
        load(tmp_path, text)
    assert "\n" not in str(caught.value)
    for word in ("model.json", *words):
        assert word in str(caught.value)


def test_each_block_has_a_line_of_its_own(tmp_path: Path) -> None:
    assembly = arch(voussoirs=60)
    io.write(assembly, tmp_path / "arch.json")
    lines = (tmp_path / "arch.json").read_text(encoding="utf-8").splitlines()
    assert len([line for line in lines if '"name"' in line]) == len(assembly)


def test_a_number_of_thousands_of_digits_is_told_in_plain_words(tmp_path: Path) -> None:
    path = tmp_path / "model.json"
    path.write_text('{"blocks": [' + "9" * 5000 + "]}", encoding="utf-8")
    with pytest.raises(FormatError, match="a whole number has thousands of digits"):
        io.read_file(path)


def test_a_load_keeps_its_acceleration_and_its_fields_on_faces(tmp_path: Path) -> None:
    assembly = tower(2)
    load = LoadCase.gravity(assembly) + LoadCase.surface_load(assembly, 1, (0, 0, -2e3))
    path = tmp_path / "tower.json"
    io.write(Model.of(assembly, load=load), path)
    again = io.read(path).load
    assert again.acceleration.tolist() == load.acceleration.tolist()
    for key, values in vars(load.surface).items():
        np.testing.assert_array_equal(getattr(again.surface, key), values)
    data = json.loads(path.read_text())
    data["loads"][0]["surface"]["block"][0] = 7
    path.write_text(json.dumps(data))
    with pytest.raises(FormatError, match="is not below"):
        io.read(path)
