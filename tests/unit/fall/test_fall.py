"""A film of what falls: it lies at the end, scales, and is played and written."""

import json
import struct
import sys
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

import drystone
from drystone import Assembly, InputError, LoadCase, MissingDependency, Model
from drystone.cli import main
from drystone.fall import FallOptions, Film, fall
from drystone.models import box, concave, stool, tower, wedge

Capsys = pytest.CaptureFixture[str]
FLOOR = box((6.0, 6.0, 0.5), (-3.0, -3.0, -0.5), "floor")
needs_mujoco = pytest.mark.skipif(find_spec("mujoco") is None, reason="MuJoCo is missing")


def dropped(height: float = 2.0, scale: float = 1.0) -> Assembly:
    """A cube of 1 m in the air above a floor."""
    blocks = (FLOOR, box((1.0, 1.0, 1.0), (-0.5, -0.5, height), "cube"))
    made = tuple(one.transformed(scale * np.eye(3)) for one in blocks)
    return Assembly(made).with_fixed(["floor"])


@needs_mujoco
@pytest.mark.parametrize("scale", [0.05, 1.0, 30.0])
def test_a_block_falls_freely_and_comes_to_lie(scale: float) -> None:
    film = fall(dropped(scale=scale))
    assert film.lies
    assert film.fell.tolist() == [False, True]
    way = -film.positions[:, 1, 2]
    flying = (way > 0.05 * scale) & (way < 1.8 * scale)
    assert flying.sum() > 5
    np.testing.assert_allclose(way[flying], 0.5 * 9.81 * film.time[flying] ** 2, rtol=0.02)
    assert way[-1] == pytest.approx(2.0 * scale, rel=1e-2)


@needs_mujoco
def test_a_block_slides_down_and_friction_takes_its_share() -> None:
    # on a slope of 40 degrees at friction 0.2: a = g (sin 40 - 0.2 cos 40)
    load = LoadCase.tilt(dropped(0.0), (0.0, 1.0, 0.0), 40.0)
    model = Model.of(dropped(0.0), friction=0.2, load=load)
    film = fall(model, options=FallOptions(ground=False, duration=3.0))
    way = np.linalg.norm(film.positions[:, 1, :3], axis=1)
    slope = np.deg2rad(40.0)
    pull = 9.81 * (np.sin(slope) - 0.2 * np.cos(slope))
    late = way > 0.2
    assert late.sum() > 3
    np.testing.assert_allclose(way[late], 0.5 * pull * film.time[late] ** 2, rtol=0.05)


@needs_mujoco
def test_what_stands_does_not_fall_and_a_first_motion_begins_the_film() -> None:
    still = fall(tower(3), friction=0.6)
    assert still.lies
    assert not still.fell.any()
    assert still.message.startswith("nothing fell")
    motion = np.zeros((2, 6))
    motion[1, 0] = 5.0
    slow, fast = (fall(tower(2), motion, options=FallOptions(nudge=x)) for x in (0.02, 2.0))
    assert not slow.fell.any()
    assert fast.fell[1]


@needs_mujoco
def test_a_film_waits_for_a_wedge_that_begins_to_fall_slowly() -> None:
    # for two seconds it moves by a thousandth of its size
    assembly = wedge("b")
    load = LoadCase.tilt(assembly, (1.0, 0.0, 0.0), 62.0)
    result = drystone.check(assembly, friction=0.84, load=load)
    assert result.verdict is drystone.Verdict.UNSTABLE
    film = fall(result.model, result.mechanism)
    assert film.fell.sum() == 1
    assert film.lies
    assert film.time[-1] < 7.0


@needs_mujoco
def test_a_concave_block_is_caught_by_its_own_shape() -> None:
    # a stool falls on a post between its legs: its seat stays above the post
    assembly = stool()
    seat = assembly.blocks[1]
    low, high = seat.bounds
    middle = 0.5 * (low + high)
    post = box((0.06, 0.06, 0.3), (middle[0] - 0.03, middle[1] - 0.03, low[2]), "post")
    lifted = seat.transformed(translation=(0.0, 0.0, 0.1))
    made = Assembly((assembly.blocks[0], post, lifted)).with_fixed([0, 1])
    film = fall(made, options=FallOptions(duration=10.0))
    assert -film.positions[-1, 2, 2] == pytest.approx(0.1, abs=0.01)  # the legs reach the floor
    tall = box((0.06, 0.06, 0.45), (middle[0] - 0.03, middle[1] - 0.03, low[2]), "post")
    caught = fall(
        Assembly((assembly.blocks[0], tall, lifted)).with_fixed([0, 1]),
        options=FallOptions(duration=2.0),
    )
    assert -caught.positions[:8, 2, 2].max() < 0.09


@needs_mujoco
def test_rotations_go_on_beyond_half_a_turn() -> None:
    film = fall(
        Assembly((FLOOR, box((0.5, 0.5, 0.5), (2.7, -0.25, 0.0), "cube"))).with_fixed([0]),
        np.array([[0.0] * 6, [1.0, 0.0, 0.0, 0.0, 8.0, 0.0]]),
        options=FallOptions(nudge=4.0, ground=False, duration=12.0),
    )
    turned = np.linalg.norm(np.diff(film.positions[:, 1, 3:], axis=0), axis=1)
    assert turned.max() < 2.0
    assert np.linalg.norm(film.positions[-1, 1, 3:]) > np.pi


@pytest.fixture(scope="module")
def film() -> Film:
    """Without a simulator: a quarter turn and a way."""
    positions = np.zeros((5, 2, 6))
    positions[:, 1, 0] = np.linspace(0.0, 1.0, 5)
    positions[:, 1, 4] = np.linspace(0.0, np.pi / 2.0, 5)
    return Film(Model.of(tower(2)), np.linspace(0.0, 1.0, 5), positions, True, "by hand")


def test_a_film_is_an_animated_glb(film: Film, tmp_path: Path) -> None:
    target = tmp_path / "film.glb"
    film.save_glb(target)
    data = target.read_bytes()
    magic, version, length = struct.unpack_from("<3I", data)
    assert (magic, version, length) == (0x46546C67, 2, len(data))
    size, _ = struct.unpack_from("<2I", data, 12)
    content = json.loads(data[20 : 20 + size])
    binary = data[20 + size + 8 :]
    (animation,) = content["animations"]
    paths = {
        c["target"]["path"]: animation["samplers"][c["sampler"]] for c in animation["channels"]
    }
    assert set(paths) == {"translation", "rotation"}

    def array(number: int) -> np.ndarray:
        accessor = content["accessors"][number]
        view = content["bufferViews"][accessor["bufferView"]]
        width = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}[accessor["type"]]
        found = np.frombuffer(binary, "<f4", accessor["count"] * width, view["byteOffset"])
        return found.reshape(-1, width)

    (node,) = {c["target"]["node"] for c in animation["channels"]}
    assert content["nodes"][node]["name"] == "block-1"
    place = array(paths["translation"]["output"])
    np.testing.assert_allclose(place[-1] - place[0], [1.0, 0.0, 0.0], atol=1e-6)
    # about y of the model, which is -z of the file
    half = np.sqrt(0.5)
    np.testing.assert_allclose(
        array(paths["rotation"]["output"])[-1], [0, 0, -half, half], atol=1e-6
    )
    np.testing.assert_allclose(array(paths["translation"]["input"])[:, 0], film.time)
    child = content["nodes"][content["nodes"][node]["children"][0]]
    np.testing.assert_allclose(child["translation"], -place[0], atol=1e-6)
    assert len(drystone.read(target, supports=[0]).assembly) == 2


def test_a_film_is_a_table_plain_values_and_a_page(film: Film, tmp_path: Path) -> None:
    assert repr(film) == "Film(5 frames, '1 block fell in 1 s and lies')"
    assert film.table()["move"][:, 0].tolist() == [0.0, 1.0]
    assert json.loads(json.dumps(film.to_dict()))["fell"] == ["block-1"]
    drystone.save_page(film, tmp_path / "film.html")
    assert "no verdict" in (tmp_path / "film.html").read_text(encoding="utf-8")


def test_bad_input_is_told() -> None:
    with pytest.raises(InputError, match="duration is 0"):
        FallOptions(duration=0.0)
    with pytest.raises(InputError, match="nudge is -1"):
        FallOptions(nudge=-1.0)
    with pytest.raises(InputError, match="first motion"):
        fall(tower(2), np.zeros((3, 6)))


def test_without_mujoco_the_extra_is_named(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: Capsys
) -> None:
    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(MissingDependency, match=r"pip install '\.\[fall\]'"):
        fall(tower(2))
    drystone.write(Model.of(tower(2)), tmp_path / "tower.json")
    assert main(["fall", str(tmp_path / "tower.json")]) == 3
    assert ".[fall]" in capsys.readouterr().err


@needs_mujoco
def test_the_command_makes_a_film(tmp_path: Path, capsys: Capsys) -> None:
    path = tmp_path / "tower.json"
    drystone.write(Model.of(tower(3), friction=0.6), path)
    files = ["--html", str(tmp_path / "fall.html"), "--glb", str(tmp_path / "fall.glb")]
    assert main(["fall", str(path), "--seismic", "0.6", *files, "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["fell"] == ["block-1", "block-2"]
    assert any(note.startswith("check: unstable") for note in told["notes"])
    assert (tmp_path / "fall.html").exists()
    assert (tmp_path / "fall.glb").exists()
    assert main(["fall", str(path), "--no-check"]) == 0
    assert "nothing fell" in capsys.readouterr().out


@needs_mujoco
def test_what_falls_and_jams_in_the_simulator_is_told(tmp_path: Path, capsys: Capsys) -> None:
    # it slides between two parallel faces: associated friction cannot open both
    path = tmp_path / "plank.json"
    drystone.write(Model.of(concave("short"), friction=0.6, load=(8.0, 0.0, -5.0)), path)
    assert main(["fall", str(path), "--gravity", "8,0,-5", "--duration", "2", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["fell"] == []
    assert any("simulator holds what falls" in note for note in told["notes"])
