import json
from pathlib import Path

import pytest

from drystone import Assembly, Model, io
from drystone.cli import main
from drystone.models import arch, box, tower
from drystone.ties import tied

Capsys = pytest.CaptureFixture[str]


@pytest.mark.parametrize("suffix", [".json", ".obj", ".stl", ".ply", ".glb"])
def test_convert_writes_every_format_that_it_reads(
    tmp_path: Path, capsys: Capsys, suffix: str
) -> None:
    source, target = tmp_path / "arch.json", tmp_path / f"out{suffix}"
    io.write(arch(), source)
    assert main(["convert", str(source), str(target)]) == 0
    out = capsys.readouterr().out
    assert f"{len(arch())} blocks, " in out
    assert f"wrote {target}\n" in out
    again = io.read(target).assembly
    assert again.names == arch().names
    assert again.volume == pytest.approx(arch().volume, rel=1e-5)


@pytest.mark.parametrize("name", ["drystone", "compas-assembly", "compas-dem"])
def test_the_format_can_be_named_and_contacts_written(
    tmp_path: Path, capsys: Capsys, name: str
) -> None:
    source, target = tmp_path / "tower.obj", tmp_path / "out.json"
    io.write(tower(3), source)
    arguments = ["convert", str(source), str(target), "--to", name, "--contacts", "--json"]
    assert main([*arguments, "--supports", "lowest", "--friction", "0.7"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert (told["blocks"], told["fixed"], told["interfaces"]) == (3, 1, 2)
    model = io.read(target)
    assert model.assembly.fixed.tolist() == [True, False, False]
    assert model.contacts is not None
    assert model.contacts.count == 2
    if name.startswith("drystone"):
        assert model.contacts.friction.tolist() == [0.7, 0.7]


def test_the_friction_that_is_asked_is_written_or_refused(tmp_path: Path, capsys: Capsys) -> None:
    source, scene = str(tmp_path / "tower.json"), tmp_path / "scene.xml"
    io.write(tower(2), source)
    assert main(["convert", source, str(scene), "--friction", "0.5"]) == 0
    assert 'friction="0.5 0 0"' in scene.read_text()
    for name, words in (("out.json", "add --contacts"), ("out.obj", "does not store it")):
        assert main(["convert", source, str(tmp_path / name), "--friction", "0.5"]) == 2
        assert words in capsys.readouterr().err
    arguments = ["--friction", "0.5", "--joint-allowance", "1mm", "--overwrite"]
    assert main(["convert", source, str(scene), *arguments]) == 2
    assert "touch nowhere" in capsys.readouterr().err


def test_what_a_format_has_no_place_for_is_told(tmp_path: Path, capsys: Capsys) -> None:
    io.write(tower(2), tmp_path / "tower.json")
    main(["convert", str(tmp_path / "tower.json"), str(tmp_path / "tower.stl")])
    assert "does not store polygons, supports, densities" in capsys.readouterr().out


@pytest.mark.parametrize(("name", "kept"), [("t.obj", False), ("t.urdf", False), ("t.json", True)])
def test_ties_that_a_format_loses_are_told(
    tmp_path: Path, capsys: Capsys, name: str, kept: bool
) -> None:
    source = str(tmp_path / "tied.json")
    io.write(tied(Model.of(tower(3)), 2, 0), source)
    assert main(["convert", source, str(tmp_path / name)]) == 0
    told = " ".join(capsys.readouterr().out.split())
    assert ("ties and glue are not in this file" not in told) == kept
    assert ("its lengths are in m, which the file does not say" in told) == name.endswith(".obj")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["out.dwg"], "suffix '.dwg' is not known"),
        (["out.gltf"], "suffix '.gltf' is not known; save it as .glb, which is glTF in one file"),
        (["out.dwg"], "these are: .3dm, .glb, .json, .mjcf, .obj, .ply, .stl, .urdf, .xml"),
        (["none/out.obj"], "cannot be written"),
        (["out.json", "--to", "dwg"], "format 'dwg' is not known"),
        (["out.obj", "--supports", "pier"], "no block is called 'pier'"),
        (["out.obj", "--units", "league"], "--units: is 'league'"),
    ],
)
def test_bad_input_writes_nothing(
    tmp_path: Path, capsys: Capsys, arguments: list[str], words: str
) -> None:
    io.write(tower(2), tmp_path / "tower.json")
    target, *options = arguments
    code = main(["convert", str(tmp_path / "tower.json"), str(tmp_path / target), *options])
    out, err = capsys.readouterr()
    assert (code, out) == (2, "")
    assert words in err
    assert err.count("\n") == 1
    assert [path.name for path in tmp_path.iterdir()] == ["tower.json"]


def test_a_model_is_not_written_over_itself_unasked(tmp_path: Path) -> None:
    path = tmp_path / "tower.obj"
    io.write(tower(2), path)
    before = path.read_bytes()
    assert main(["convert", str(path), str(tmp_path / "." / "tower.obj")]) == 2
    assert path.read_bytes() == before
    assert main(["convert", str(path), str(path), "--overwrite"]) == 0


def test_a_suffix_of_another_format_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "tower.json"
    io.write(tower(2), path)
    assert main(["convert", str(path), str(tmp_path / "x.glb"), "--to", "stl"]) == 2
    assert not (tmp_path / "x.glb").exists()
    assert main(["convert", str(path), str(tmp_path / "x.data"), "--to", "stl"]) == 0


def test_convert_gives_blocks_the_density_that_a_format_stores(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    source = str(tmp_path / "a.obj")
    io.write(tower(2), source)
    light = tmp_path / "light.json"
    assert main(["convert", source, str(light), "--density", "500"]) == 0
    assert {block.density for block in io.read_file(light).assembly.blocks} == {500.0}
    assert main(["convert", source, str(tmp_path / "b.obj"), "--density", "500"]) == 2
    assert "--density: Wavefront OBJ does not store it" in capsys.readouterr().err


def test_convert_lays_the_ground_that_is_asked_for(tmp_path: Path) -> None:
    model, out = tmp_path / "tower.json", tmp_path / "grounded.json"
    io.write(tower(2), model)
    assert main(["convert", str(model), str(out), "--supports", "ground"]) == 0
    assembly = io.read(out).assembly
    assert assembly.fixed.tolist() == [False, False, True]


def test_blocks_to_fabricate_leave_room_in_their_joints(tmp_path: Path, capsys: Capsys) -> None:
    source, target = tmp_path / "tower.obj", tmp_path / "print.json"
    io.write(tower(3), source)
    arguments = ["convert", str(source), str(target), "--joint-allowance"]
    assert main([*arguments, "0.58mm"]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "joints are open by 0.58 mm; analyse the model without it" in said
    assert io.read(target).assembly.volume == pytest.approx([0.99971, 0.99942, 0.99971])
    assert main([*arguments, "-1mm"]) == 2
    assert main([*arguments, "1mm", "--contacts"]) == 2


def test_a_model_is_written_in_the_unit_that_is_asked(tmp_path: Path, capsys: Capsys) -> None:
    source, target = tmp_path / "tower.json", tmp_path / "tower.obj"
    io.write(tower(2), source)
    assert main(["convert", str(source), str(target), "--to-units", "mm"]) == 0
    assert "in mm, which the file does not say: --units mm" in capsys.readouterr().out
    assert io.read(target, units="mm").assembly.volume == pytest.approx(tower(2).volume)
    assert main(["convert", str(source), str(tmp_path / "a.xml"), "--to-units", "mm"]) == 2


def test_mends_are_written_in_the_unit_of_the_file(tmp_path: Path, capsys: Capsys) -> None:
    base, out = box((1.0, 1.0, 1.0), name="base"), box((1.0, 1.0, 0.2), (0.7, 0.0, 1.0), "out")
    source, target = str(tmp_path / "model.obj"), str(tmp_path / "mended.obj")
    io.write(Assembly((base, out)), source, units="mm")
    how = ["--units", "mm", "--supports", "lowest"]
    mend = ["mend", source, *how, "--kind", "prop", "--apply", "1"]
    assert main([*mend, "--out", target]) == 0
    told = capsys.readouterr().out
    assert "this format does not store supports" in told
    assert "its lengths are in mm" in told
    assert "ties and glue" not in told
    again = io.read_file(target, units="mm").assembly
    assert again.names == ("base", "out", "prop-1")
    glued = ["mend", source, *how, "--kind", "glue", "--apply", "1", "--out"]
    assert main([*glued, str(tmp_path / "glued.obj")]) == 0
    assert "ties and glue are not in this file" in capsys.readouterr().out
    assert again.volume[:2] == pytest.approx([1.0, 0.2])
    assert main([*mend, "--out", str(tmp_path / "mended.dxf")]) == 2
    assert "does not end in .json, .3dm" in capsys.readouterr().err
