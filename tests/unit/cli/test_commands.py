"""What check, inspect and demo answer."""

import dataclasses
import json
import shlex
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import drystone
from drystone import io
from drystone.assembly import Assembly, replace_block
from drystone.cli import main
from drystone.model import Model
from drystone.models import arch, box, incline, prism, tower, vault
from drystone.view.palette import ROLE_COLOUR
from tests.unit.cli.running import Capsys, answer, refused


def file(tmp_path: Path, assembly: Assembly, name: str = "model.json") -> str:
    io.write(assembly, tmp_path / name)
    return str(tmp_path / name)


def boxes(**places: tuple[float, float, float]) -> Assembly:
    """Unit cubes at given places, the first fixed."""
    blocks = [box((1.0, 1.0, 1.0), at, name=name) for name, at in places.items()]
    return Assembly(tuple(blocks), np.arange(len(blocks)) == 0)


def test_check_answers_for_a_standing_model(tmp_path: Path, capsys: Capsys) -> None:
    code, told = answer(capsys, "check", file(tmp_path, tower(3)))
    assert code == 0
    assert told["verdict"] == "stable"
    assert told["method"] == "check"
    asked = told["asked"]
    assert (asked["blocks"], asked["interfaces"], asked["supports"]) == (3, 2, ["block-0"])
    assert told["falling"] == told["notes"] == told["files"] == []
    assert "gives_way" not in told
    assert told["samples"]["standing"] == told["samples"]["tried"] > 0
    for key in ("equilibrium", "cone", "complementarity", "alignment"):
        assert 0.0 <= told["residuals"][key] <= 1e-8
    assert set(told["time_s"]) >= {"read", "detect", "solve"}
    assert all(seconds > 0.0 for seconds in told["time_s"].values())
    assert asked["free_mass"] == pytest.approx(2 * 2400.0)
    force = told["most_loaded"][0]
    assert (force["block_a"], force["block_b"]) == ("block-0", "block-1")
    assert force["normal"] == pytest.approx(2 * 2400.0 * 9.81)


def test_a_check_without_a_margin_names_the_command_that_finds_it(
    tmp_path: Path, capsys: Capsys
) -> None:
    model = file(tmp_path, tower(2))
    _, told = answer(capsys, "check", model)
    assert told["tilt_margin"] > 0.0
    assert "next" not in told
    _, told = answer(capsys, "check", model, "--joint-capacity", "tension=1kPa")
    assert told["next"] == f"drystone limit tilt {model} --joint-capacity tension=1kPa"
    assert main(shlex.split(told["next"])[1:]) == 0
    assert main(["models", "segmental-bridge", "--set", "voussoirs=4", "--out", model]) == 0
    assert "Of the intrados, 6 and 1.5 when left out" in capsys.readouterr().out
    words = ("--load", "fill:cover=0.3m,weight=20kN/m3,k=0.3,passive=1.5", "--tie", "fill")
    _, told = answer(capsys, "check", model, *words)
    assert told["next"].startswith(f"drystone limit train {model} --load fill:")
    assert told["next"].endswith(" --tie fill --train lm1")


def test_check_names_the_blocks_that_fall_and_what_would_hold_them(
    tmp_path: Path, capsys: Capsys
) -> None:
    model = boxes(base=(0, 0, 0), good=(0.1, 0, 1), bad=(0.9, 0, 2))
    code, told = answer(capsys, "check", file(tmp_path, model))
    assert code == 1
    assert told["verdict"] == "unstable"
    assert told["falling"] == ["bad"]
    (prop,) = told["gives_way"]
    assert prop["block"] == "bad"
    assert prop["missing_force"][2] > 0.0
    assert len(prop["missing_moment"]) == 3


def test_a_block_that_touches_nothing_falls_and_is_named(tmp_path: Path, capsys: Capsys) -> None:
    code, told = answer(capsys, "check", file(tmp_path, boxes(base=(0, 0, 0), lone=(5, 5, 5))))
    assert code == 1
    assert told["falling"] == ["lone"]
    assert any("touching nothing" in note and "'lone'" in note for note in told["notes"])


def test_blocks_that_overlap_are_refused_or_told_with_the_depth(
    tmp_path: Path, capsys: Capsys
) -> None:
    model = boxes(base=(0, 0, 0), on=(0, 0, 1), deep=(0, 0, 1.8))
    assert main(["check", file(tmp_path, model)]) == 2
    said = capsys.readouterr().err
    assert "blocks 'on' and 'deep': overlap: they share 0.2 m3 (20 % of the smaller one)" in said
    _, told = answer(capsys, "check", file(tmp_path, model), "--anyway")
    (note,) = [note for note in told["notes"] if "they share" in note]
    assert "'on' and 'deep'" in note
    assert "200 mm" in note


@pytest.mark.parametrize(("friction", "code"), [("0.5", 0), ("0.3", 1)])
def test_the_exit_code_follows_the_verdict(
    tmp_path: Path, capsys: Capsys, friction: str, code: int
) -> None:
    model = file(tmp_path, incline(21.8))
    assert answer(capsys, "check", model, "--friction", friction)[0] == code


@pytest.mark.parametrize(
    ("gravity", "verdict"),
    [("9.81", "stable"), ("1.62", "stable"), ("4.8,0,-9.81", "stable"), ("5,0,-9.81", "unstable")],
)
def test_gravity_has_a_size_and_a_direction(
    tmp_path: Path, capsys: Capsys, gravity: str, verdict: str
) -> None:
    """With a friction of one half, a cube slides once gravity leans by more than 1 in 2."""
    arguments = ("check", file(tmp_path, tower(2)), "--gravity", gravity, "--friction", "0.5")
    assert answer(capsys, *arguments)[1]["verdict"] == verdict


def test_density_and_units_scale_the_mass_and_not_the_verdict(
    tmp_path: Path, capsys: Capsys
) -> None:
    path = tmp_path / "model.json"
    blocks = [
        {"name": b.name, "vertices": b.vertices.tolist(), "faces": b.faces, "fixed": bool(f)}
        for b, f in zip(*(lambda a: (a.blocks, a.fixed))(tower(2)), strict=True)
    ]
    path.write_text(json.dumps({"blocks": blocks}), encoding="utf-8")
    code, told = answer(capsys, "check", str(path), "--density", "1000", "--units", "cm")
    assert (code, told["verdict"]) == (0, "stable")
    assert told["asked"]["free_mass"] == pytest.approx(1e-3)


def test_friction_that_blocks_bring_holds_at_their_joints(tmp_path: Path, capsys: Capsys) -> None:
    base, slab = incline(21.8).blocks
    fixed = incline(21.8).fixed
    smooth = Assembly((base, replace_block(slab, metadata={"friction": 0.3})), fixed)
    _, told = answer(capsys, "check", file(tmp_path, smooth))
    assert told["verdict"] == "unstable"
    assert told["notes"] == ["joints have the friction that their blocks bring"]
    _, told = answer(capsys, "check", file(tmp_path, smooth), "--friction", "0.5")
    assert (told["verdict"], told["notes"]) == ("stable", [])


def test_supports_of_the_command_line_replace_those_of_the_file(
    tmp_path: Path, capsys: Capsys
) -> None:
    model = file(tmp_path, tower(3))
    told = answer(capsys, "check", model, "--supports", "block-2,block-1")[1]
    assert told["asked"]["supports"] == ["block-1", "block-2"]
    assert told["falling"] == ["block-0"]


def test_contacts_and_loads_of_a_file_are_used_unless_told_otherwise(
    tmp_path: Path, capsys: Capsys
) -> None:
    from drystone.detection import find_contacts
    from drystone.loads import LoadCase

    assembly = tower(2)
    contacts = find_contacts(assembly, friction=0.9).contacts
    push = LoadCase.gravity(assembly) + LoadCase.point_load(assembly, 1, (1.5e4, 0, 0))
    saved = io.Contents(assembly, contacts, (dataclasses.replace(push, name="push"),))
    io.write(saved, tmp_path / "model.json")
    model = str(tmp_path / "model.json")
    _, told = answer(capsys, "check", model)
    assert told["notes"] == [
        "the 1 interface of the file is used",
        "the load case 'push' of the file is used",
    ]
    assert told["most_loaded"][1]["friction_used"] == pytest.approx(1.5e4 / (0.9 * 2400 * 9.81))
    assert answer(capsys, "check", model, "--friction", "0.6")[0] == 1
    denser = io.read(model, density=4800.0).load.wrench  # the push stays
    assert denser[1] == pytest.approx([1.5e4, 0.0, -4800 * 9.81, 0.0, 0.0, 0.0])
    own = ("check", model, "--find-contacts", "--gravity", "9.81")
    assert "the load case 'push' of the file is more than weight" in refused(capsys, *own)
    _, told = answer(capsys, *own, "--case", "weight")
    assert told["notes"] == []
    (largest,) = told["most_loaded"]  # no joint uses friction
    assert largest["friction_used"] == pytest.approx(0.0, abs=1e-9)


Y_UP = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])


def test_an_improbable_size_is_told_before_anything_is_solved(
    tmp_path: Path, capsys: Capsys
) -> None:
    model = file(tmp_path, tower(2, edge=500.0), "tower.obj")
    main(["check", model, "--supports", "lowest"])
    assert "is the unit right (--units mm)?" in capsys.readouterr().err


def test_a_model_that_lies_on_its_side_is_told_to_stand_up(tmp_path: Path, capsys: Capsys) -> None:
    model = file(tmp_path, vault().transformed(Y_UP), "lying.obj")
    note = "it falls as it is, and stands with y up: does y point up in the file? (--up y)"
    code, told = answer(capsys, "check", model, "--supports", "lowest")
    assert (code, note in told["notes"]) == (1, True)
    code, told = answer(capsys, "check", model, "--supports", "lowest", "--up", "y")
    assert (code, told["notes"]) == (0, [])
    fallen = file(tmp_path, boxes(base=(0, 0, 0), far=(0, 3, 0)), "fallen.obj")
    _, told = answer(capsys, "check", fallen, "--supports", "base")
    assert note not in told["notes"]


def test_all_blocks_fixed_is_bad_input_with_advice(tmp_path: Path, capsys: Capsys) -> None:
    model = file(tmp_path, arch().transformed(Y_UP), "lying.obj")
    for spec, advice in (("lowest", "With --up y 'lowest' fixes 2 blocks"), ("*", "name fewer")):
        assert main(["check", model, "--supports", spec]) == 2
        out, err = capsys.readouterr()
        assert out == ""
        assert "every block is fixed, all 38" in err
        assert advice in err


def test_blocks_that_lie_on_their_side_are_inspected_and_converted_upright(
    tmp_path: Path, capsys: Capsys
) -> None:
    model = file(tmp_path, arch().transformed(Y_UP), "lying.obj")
    _, told = answer(capsys, "inspect", model, "--supports", "lowest")
    assert "With --up y 'lowest' fixes 2 blocks" in told["notes"][-1]
    assert main(["convert", model, str(tmp_path / "upright.obj"), "--up", "y"]) == 0
    capsys.readouterr()
    for file_and_axis in ([model, "--up", "y"], [str(tmp_path / "upright.obj")]):
        _, told = answer(capsys, "inspect", *file_and_axis, "--supports", "lowest")
        assert told["notes"] == []
        assert told["places"][0]["bounds"] == pytest.approx(arch().blocks[0].bounds)


def test_size_and_mass_are_told(tmp_path: Path, capsys: Capsys) -> None:
    _, told = answer(capsys, "check", file(tmp_path, tower(3)))
    assert told["asked"]["size"] == pytest.approx([1.0, 1.0, 3.0])
    for command in ("check", "inspect"):
        assert main([command, file(tmp_path, tower(3))]) == 0
        assert "1 x 1 x 3 m" in capsys.readouterr().out


def test_equal_rows_and_equal_defects_share_a_line(tmp_path: Path, capsys: Capsys) -> None:
    assert main(["inspect", file(tmp_path, tower(9))]) == 0
    assert "block-1, block-2, block-3 and 5 more" in capsys.readouterr().out
    cube = box((1.0, 1.0, 1.0))
    blocks = [
        {
            "name": f"b{i}",
            "vertices": (cube.vertices + np.array([2.0 * i, 0, 0])).tolist(),
            "faces": cube.faces[1:],
        }
        for i in range(5)
    ]
    path = tmp_path / "open.json"
    path.write_text(json.dumps({"blocks": blocks}), encoding="utf-8")
    assert main(["inspect", str(path)]) == 2
    out = capsys.readouterr().out
    assert out.count("defect:") == 1
    assert "(4 more: open mesh; --json lists all)" in " ".join(out.split())


def test_check_writes_the_page_and_the_figure(tmp_path: Path, capsys: Capsys) -> None:
    page, figure = tmp_path / "page.html", tmp_path / "figure.svg"
    model = file(tmp_path, tower(2))
    _, told = answer(capsys, "check", model, "--html", str(page), "--png", str(figure))
    assert told["files"] == [str(page), str(figure)]
    assert page.read_text(encoding="utf-8").startswith("<!doctype html>")
    assert "<svg" in figure.read_text(encoding="utf-8")


def test_check_tells_a_person_the_same(tmp_path: Path, capsys: Capsys) -> None:
    model = boxes(base=(0, 0, 0), good=(0.1, 0, 1), bad=(0.9, 0, 2))
    assert main(["check", file(tmp_path, model)]) == 1
    out, err = capsys.readouterr()
    assert err == ""
    for words in (
        "UNSTABLE",
        "gives way",
        "bad",
        "missing force",
        "3 blocks",
        "free mass 4.8 t",
    ):
        assert words in out
    assert main(["check", file(tmp_path, tower(2))]) == 0
    out, _ = capsys.readouterr()
    for words in ("STABLE", "largest force", "block-0", "23.5 kN", "read", "solve"):
        assert words in out


def test_strict_wants_a_model_that_stands_whatever_the_stiffness() -> None:
    from drystone.cli.check_command import exit_code
    from drystone.contacts import Contacts
    from drystone.loads import LoadCase
    from drystone.results import Result, Samples, Verdict

    assembly = tower(2)
    load = LoadCase.gravity(assembly)

    def result(verdict: Verdict, tried: int, standing: int) -> Result:
        samples = Samples(tried, standing)
        return Result("check", verdict, Model(assembly, Contacts.empty(), load), samples=samples)

    robust = result(Verdict.STABLE, 5, 5)
    sensitive = result(Verdict.STABLE, 5, 2)
    assert [robust.sensitive, sensitive.sensitive] == [False, True]
    assert [exit_code(robust, strict=True), exit_code(sensitive, strict=True)] == [0, 1]
    assert [exit_code(robust, strict=False), exit_code(sensitive, strict=False)] == [0, 0]
    for verdict in (Verdict.UNSTABLE, Verdict.UNDECIDED, Verdict.EQUILIBRIUM_EXISTS):
        assert exit_code(result(verdict, 5, 5), strict=False) == 1


def test_a_load_on_each_of_many_blocks_does_not_bury_the_answer(
    tmp_path: Path, capsys: Capsys
) -> None:
    loads = [word for i in range(1, 8) for word in ("--load", f"block-{i}:{i}N")]
    assert main(["check", file(tmp_path, tower(8)), "--supports", "lowest", *loads]) == 0
    out, _ = capsys.readouterr()
    assert "and 3 more (--json lists all)" in out
    assert main(["check", file(tmp_path, tower(8)), "--supports", "lowest", *loads[:10]]) == 0
    out, _ = capsys.readouterr()
    assert "block-5" in out.split("loads:")[1]  # one row alone is not folded
    assert "more (--json" not in out


def test_inspect_lists_blocks_defects_and_contacts(tmp_path: Path, capsys: Capsys) -> None:
    code, told = answer(capsys, "inspect", file(tmp_path, arch()))
    assert code == 0
    assert len(told["blocks"]) == len(arch())
    assert told["volume"] == pytest.approx(float(arch().volume.sum()))
    assert told["defects"] == []
    assert told["contacts"]["pairs"] == len(arch()) - 1
    assert main(["inspect", file(tmp_path, arch()), "--supports", "lowest"]) == 0
    out, _ = capsys.readouterr()
    assert f"{len(arch())} blocks, 2 of them fixed" in out
    assert "--json lists all" in out
    assert main(["inspect", file(tmp_path, tower(2)), "--supports", "ground"]) == 0
    out, _ = capsys.readouterr()
    assert "2 blocks, 0 of them fixed" in out
    assert "· 2 blocks ·" in out
    assert "friction" not in out, "contacts are found anew: the file may say another one"


def test_inspect_draws_what_was_missed(tmp_path: Path, capsys: Capsys) -> None:
    model = file(tmp_path, boxes(base=(0, 0, 0), on=(0, 0, 1), near=(0, 0, 2.02)))
    page, figure = tmp_path / "contacts.html", tmp_path / "contacts.svg"
    pictures = ("--html", str(page), "--png", str(figure))
    _, told = answer(capsys, "inspect", model, *pictures)
    assert told["files"] == [str(page), str(figure)]
    assert told["contacts"]["missed"]
    text = page.read_text(encoding="utf-8")
    assert text.startswith("<!doctype html>")
    assert "<svg" in text
    assert "near misses" in text
    drawn = figure.read_text(encoding="utf-8").lower()
    assert all(ROLE_COLOUR["light"][role].lower() in drawn for role in ("missed", "interface"))


def test_the_page_is_not_written_without_the_figure(
    tmp_path: Path, capsys: Capsys, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: Any, **__: Any) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("drystone.view.save_figure", full)
    model, page = file(tmp_path, tower(2)), tmp_path / "page.html"
    for command in ("check", "inspect"):
        figure = str(tmp_path / "figure.png")
        assert main([command, model, "--html", str(page), "--png", figure]) == 2
        assert "figure.png: cannot be written: No space left" in capsys.readouterr().err
        assert [path.name for path in tmp_path.iterdir()] == ["model.json"]


def test_demo_checks_a_vault_and_draws_it_where_it_is_asked(
    tmp_path: Path, capsys: Capsys, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["demo"]) == 0
    assert capsys.readouterr().out.startswith("STABLE")
    names = {path.name for path in tmp_path.iterdir()}
    assert names == {"drystone-demo.json", "drystone-demo.html", "drystone-demo.png"}
    assert answer(capsys, "check", str(tmp_path / "drystone-demo.json"))[1]["asked"]["blocks"] == 97
    assert (tmp_path / "drystone-demo.png").read_bytes().startswith(b"\x89PNG")


def test_an_interrupted_check_writes_nothing(
    tmp_path: Path, capsys: Capsys, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(*_: Any, **__: Any) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("drystone.stability.check", interrupted)
    model = file(tmp_path, tower(2))
    code = main(["check", model, "--html", str(tmp_path / "page.html")])
    out, err = capsys.readouterr()
    assert (code, out, err) == (130, "", "drystone: interrupted; nothing was written\n")
    assert [path.name for path in tmp_path.iterdir()] == ["model.json"]


def test_names_from_files_cannot_talk_to_the_terminal(tmp_path: Path, capsys: Capsys) -> None:
    model = boxes(**{"base": (0, 0, 0), "\x1b[31m[bold]evil\n": (5, 5, 5)})
    assert main(["check", file(tmp_path, model)]) == 1
    assert main(["inspect", file(tmp_path, model)]) == 0
    out, err = capsys.readouterr()
    assert "\x1b" not in out + err
    assert "?[31m[bold]evil?" in out


def test_angle_and_edges_of_the_search_are_options(tmp_path: Path, capsys: Capsys) -> None:
    slab = box((4.0, 4.0, 0.5), (-2.0, -2.0, -0.5), "slab")
    wedge = prism([(0.0, 0.0), (1.0, 0.05), (1.0, 1.0), (0.0, 1.0)], (0.0, 1.0), "wedge")
    model = file(tmp_path, Assembly((slab, wedge), np.array([True, False])))
    _, told = answer(capsys, "inspect", model)
    assert {one["kind"] for one in told["contacts"]["interfaces"]} == {"line"}
    _, told = answer(capsys, "inspect", model, "--angle", "4")
    assert {one["kind"] for one in told["contacts"]["interfaces"]} == {"area"}
    _, told = answer(capsys, "inspect", model, "--edges", "never")
    assert told["contacts"]["interfaces"] == []
    code, _ = answer(capsys, "check", model, "--angle", "4", "--edges", "always")
    assert code in (0, 1)
    for command in ("settle", "plan"):
        assert main([command, model, "--angle", "90"]) == 2
        assert "give 0 or more, up to 45" in capsys.readouterr().err
    for wrong, remedy in (
        (("--angle", "90"), "give 0 or more, up to 45"),
        (("--gap", "5"), "or a length such as 5mm"),
        (("--edges", "x"), "always"),
    ):
        assert main(["inspect", model, *wrong]) == 2
        assert remedy in capsys.readouterr().err


def test_an_answer_is_written_for_cad_programs(
    tmp_path: Path, capsys: Capsys, monkeypatch: pytest.MonkeyPatch
) -> None:
    model, target = file(tmp_path, tower(3)), tmp_path / "answer.glb"
    for command in ("check", "plan"):
        assert main([command, model, "--friction", "0.7", "--cad", str(target)]) == 0
        assert f"wrote {target}" in capsys.readouterr().out
        assert target.read_bytes()[:4] == b"glTF"
        target.unlink()
    monkeypatch.setattr("importlib.util.find_spec", lambda name, package=None: None)
    for command in ("check", "plan"):
        assert main([command, model, "--cad", str(tmp_path / "answer.3dm")]) == 3
        assert "rhino3dm" in capsys.readouterr().err


def test_of_many_blocks_that_need_help_the_first_are_named(tmp_path: Path, capsys: Capsys) -> None:
    model = file(tmp_path, arch(0.15, 6))
    for more in ((), ("--auto",)):
        main(["mend", model, "--friction", "0.1", "--kind", "friction", *more])
        told = capsys.readouterr().out
        assert "voussoir-02 and 3 more" in told.replace("'", "")
        assert "friction of 0.37 in all its joints" in told


def test_that_a_file_weighs_what_it_weighs_is_not_told(tmp_path: Path, capsys: Capsys) -> None:
    path = str(tmp_path / "tower.json")
    io.write(Model.of(tower(2)), path)
    assert main(["check", path]) == 0
    assert "the load case" not in capsys.readouterr().out


def test_a_file_of_one_block_is_told_how_a_surface_is_cut(tmp_path: Path, capsys: Capsys) -> None:
    lone = file(tmp_path, tower(2).subset([1]))
    words = f"drystone shell {lone} --units mm --courses 11"
    assert main(["inspect", lone, "--units", "mm"]) == 0
    assert words in " ".join(capsys.readouterr().out.split())
    assert main(["check", lone, "--units", "mm", "--supports", "ground"]) == 0
    assert words in " ".join(capsys.readouterr().out.split())
    assert main(["check", lone, "--units", "mm", "--supports", "lowest"]) == 2
    assert words in " ".join(capsys.readouterr().err.split())
    assert main(["check", file(tmp_path, tower(2))]) == 0
    assert "drystone shell" not in capsys.readouterr().out


def test_ground_that_is_laid_is_no_block_of_the_answer(tmp_path: Path, capsys: Capsys) -> None:
    thin = file(tmp_path, arch(thickness_ratio=0.06, voussoirs=5).with_fixed([]))
    code, told = answer(capsys, "mend", thin, "--supports", "ground", "--kind", "thicker")
    assert code == 1
    falls = drystone.check(thin, supports="ground")
    assert falls.title.endswith("of 7 blocks")
    (needed,) = (one for one in falls.layers().stages[0].layers if one.key == "help")
    assert needed.label == "help needed on 7 blocks at once"
    assert told["mends"]
    assert "ground" not in str(told["mends"])
    out = str(tmp_path / "thick.obj")
    wish = ("--supports", "ground", "--kind", "thicker", "--apply", "1", "--out", out)
    _, told = answer(capsys, "mend", thin, *wish)
    assert "its 'ground' is the plane that supports lay, no block to build" in told["notes"]
    assert told["asked"]["blocks"] == 7
    assert f"{falls!r}".count("7 blocks") == 1
    for kept in ("kept.obj", "kept.json"):  # the second one stores supports
        wish = (str(tmp_path / kept), "--supports", "ground")
        _, told = answer(capsys, "convert", thin, *wish)
        assert told["blocks"] == 7
        assert "its 'ground' is the plane that supports lay, no block to build" in told["sentences"]


def test_many_supports_are_counted_and_the_first_are_named(tmp_path: Path, capsys: Capsys) -> None:
    row = file(tmp_path, tower(5))
    assert main(["check", row, "--supports", "block-[0-3]"]) == 0
    assert "supports: 4 blocks: block-0, block-1, block-2, ... ·" in capsys.readouterr().out
