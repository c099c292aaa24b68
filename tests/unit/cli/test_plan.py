"""drystone plan: answers, files, exit codes, bad input."""

import json
import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from drystone import LoadCase, check, io, sequence
from drystone.assembly import Assembly
from drystone.cli import main
from drystone.models import arch, box, corbelled_wall, tower
from tests.unit.cli.running import answer


@pytest.fixture
def stack(tmp_path: Path) -> str:
    path = tmp_path / "stack.json"
    io.write(tower(4), path)
    return str(path)


def test_a_stack_needs_no_help(stack, capsys):
    code, data = answer(capsys, "plan", stack)
    assert code == 0
    assert data["order"] == ["block-1", "block-2", "block-3"]
    counts = {"support": 1, "free": 3, "held": 0, "propped": 0, "impossible": 0, "unsure": 0}
    assert data["counts"] == counts
    assert [step["verdict"] for step in data["steps"]] == ["stable"] * 3


def test_a_block_is_placed_before_another_one(tmp_path, capsys):
    path = tmp_path / "three.json"
    blocks = tuple(
        box((1.0, 1.0, 1.0), (1.5 * i, 0.0, z), f"{name} {i}")
        for name, z in (("base", 0.0), ("top", 1.0))
        for i in range(3)
    )
    io.write(Assembly(blocks, np.arange(6) < 3), path)
    code, data = answer(capsys, "plan", str(path), "--before", "top 1:top 0")
    assert code == 0
    assert data["order"].index("top 1") < data["order"].index("top 0")
    assert data["notes"][-1] == f"this order: --order '{','.join(data['order'])}'"  # for a shell


def test_a_person_reads_steps_and_counts(stack, capsys):
    assert main(["plan", stack]) == 0
    out = capsys.readouterr().out
    assert "3 steps" in out
    assert "3 free, 0 held, 0 propped" in out
    assert "this order: --order block-1,block-2,block-3" in out
    assert "--margins tells what each stage has in reserve" in out
    assert "next: " not in out
    assert main(["plan", stack, "--order", "course"]) == 0
    assert "order course" in capsys.readouterr().out


def test_an_arch_names_its_props_and_writes_files(tmp_path, capsys):
    path = tmp_path / "arch.json"
    io.write(arch(0.3, 7), path)
    files = [str(tmp_path / name) for name in ("p.html", "print.html", "p.csv", "p.pdf")]
    code, data = answer(
        capsys, "plan", str(path), "--friction", "0.4", "--hands", "1", "--margins",
        "--sweep", "0.4,0.1", "--html", files[0], "--print", files[1], "--csv", files[2],
        "--png", files[3],
    )  # fmt: skip
    assert code == 1
    assert data["counts"]["propped"] == len(data["props"]) == 4
    assert data["notes"][0] == f"this order: --order {','.join(data['order'])}"
    assert data["notes"][1].startswith("props: --hands 2 gives one more hand")
    assert "drystone recut may" in data["notes"][1]
    assert data["next"] == f"drystone recut {path} --friction 0.4 --hands 1"
    assert all(np.linalg.norm(prop["force"]) > 0.0 for prop in data["props"])
    assert data["margins"]["weakest"]["tilt_deg"] > 1.0
    assert [row["stands"] for row in data["friction_sweep"]["plans_by_friction"]] == [False, True]
    assert sorted(data["files"]) == sorted(files)
    assert Path(files[3]).read_bytes().startswith(b"%PDF")
    assert all(Path(name).stat().st_size > 200 for name in files)


def test_turns_are_asked_for_and_written(stack, tmp_path, capsys):
    page, rows = tmp_path / "turns.html", tmp_path / "turns.csv"
    assert main(["plan", stack, "--turns", "--html", str(page), "--csv", str(rows)]) == 0
    assert "Can be assembled without props, by 2 robots in turn" in capsys.readouterr().out
    assert page.stat().st_size > 10_000
    assert rows.read_text().startswith("step,block,robot,hold [N],works\n1,block-1,hand 1,")


def test_turns_that_fail_in_the_order_of_the_file_say_so(tmp_path, capsys):
    path, pair = tmp_path / "leaning.json", tower(3)
    io.write(Assembly(tuple(pair.blocks[i] for i in (0, 2, 1)), pair.fixed), path)
    assert main(["plan", str(path), "--turns", "--payload", "1"]) == 1
    assert "in the order of the file: another one may do, try --order" in capsys.readouterr().out
    assert main(["plan", str(path), "--turns", "--payload", "1", "--order", "block-1,block-2"]) == 1
    assert "in the order of the file" not in capsys.readouterr().out


def test_turns_of_what_falls_when_it_is_complete_name_no_other_order(tmp_path, capsys):
    """The second brick falls when the third is held; no order places a corbel that falls."""
    path = tmp_path / "corbel.json"
    blocks = tuple(box((1.0, 1.0, 0.3), (0.4 * i, 0.0, 0.3 * i), str(i)) for i in range(4))
    io.write(Assembly(blocks, np.arange(4) < 1), path)
    code, told = answer(capsys, "plan", str(path), "--turns", "--friction", "0.5")
    assert (code, told["complete"]) == (1, "unstable")
    _, _, whole, first = told["sentences"]
    assert whole.startswith(
        "the complete structure does not stand: 1, 2, 3 fall; no contact forces"
    )
    assert first.startswith("when 'hand 1' holds '3': 1, 2 fall;")
    assert not told["notes"]
    assert told["next"] == f"drystone mend {path} --friction 0.5"
    assert answer(capsys, "plan", str(path), "--friction", "0.5")[1]["next"] == told["next"]


def test_stages_are_written_with_their_props(tmp_path, capsys):
    file, folder = tmp_path / "arch.json", tmp_path / "stages"
    io.write(arch(0.15, 11), file)
    assert main(["plan", str(file), "--friction", "0.7", "--stages", str(folder)]) == 1
    found = [io.read(path) for path in sorted(folder.iterdir())]
    assert [len(one) for one in found] == [3, 4, 6, 8, 10, 11, 12, 13]
    assert [int(one.assembly.fixed.sum()) for one in found] == [2, 2, 3, 3, 3, 3, 3, 2]
    assert all(check(one).stable for one in found)
    assert not check(found[2].with_supports(["springer-left", "springer-right"])).stable
    turned = tmp_path / "turns"
    main(["plan", str(file), "--friction", "0.7", "--turns", "--stages", str(turned)])
    last = io.read(turned / "stage-05.json")
    assert (len(last), last.assembly.fixed.sum(), check(last).stable) == (7, 3, True)
    none = tmp_path / "none"
    main(["plan", str(file), "--payload", "1", "--stages", str(none)])
    assert not none.exists()


def test_names_stay_whole_in_a_narrow_terminal(tmp_path, capsys, monkeypatch):
    """The headings are folded in their place."""
    monkeypatch.setenv("COLUMNS", "80")
    file = tmp_path / "arch.json"
    io.write(arch(0.2, 12), file)
    main(["plan", str(file), "--friction", "0.7"])
    table = capsys.readouterr().out.split("assembly plan:")[1]
    assert all(f"voussoir-{i:02}" in table for i in range(12))
    assert "propped stages" not in table


def test_words_stay_whole_in_the_tables_of_a_narrow_terminal(tmp_path, capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    file = tmp_path / "arch.json"
    io.write(arch(0.15, 36), file)
    main(["check", str(file)])
    table = capsys.readouterr().out.split("most loaded:")[1].split("reactions:")[0]
    words = set(table.split())
    assert {"interface", "tangential", "friction"} <= words
    assert {"springer-left", "voussoir-00"} <= words or {"springer-right", "voussoir-35"} <= words
    few = tmp_path / "few.json"  # eight columns: headings are broken before names
    io.write(arch(0.15, 11), few)
    main(["settle", str(few), "--friction", "0.7", "--move", "springer-right:0.01,0,0"])
    table = capsys.readouterr().out.split("joints:\n")[1]
    assert max(map(len, table.split("few.json")[0].splitlines())) <= 80
    assert {"springer-left", "springer-right", "voussoir-08"} <= set(table.split())


def test_a_person_reads_the_counts_of_a_sweep(stack, capsys):
    assert main(["plan", stack, "--sweep", "0.5"]) == 0
    assert "friction 0.5: 3 free, 0 held, 0 propped" in capsys.readouterr().out


def test_a_folder_that_is_not_there_leaves_no_file_half_the_way(stack, tmp_path, capsys):
    page, table = tmp_path / "plan.html", tmp_path / "nowhere" / "stages.csv"
    page.write_text("before")
    code = main(["plan", stack, "--html", str(page), "--csv", str(table)])
    assert code == 2
    assert "nowhere" in capsys.readouterr().err
    assert page.read_text() == "before"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["plan.html", "stack.json"]


def test_two_files_of_one_name_are_refused(stack, tmp_path, capsys):
    page = str(tmp_path / "plan.html")
    assert main(["plan", stack, "--html", page, "--print", page]) == 2
    assert "named twice" in capsys.readouterr().err
    assert not (tmp_path / "plan.html").exists()


def test_a_model_that_does_not_stand_says_so_and_is_planned_anyway_on_request(tmp_path, capsys):
    path = tmp_path / "leaning.json"
    blocks = (box((1.0, 1.0, 1.0), name="base"), box((1.0, 1.0, 1.0), (0.7, 0.0, 1.0), "top"))
    io.write(Assembly(blocks, np.array([True, False])), path)
    assert main(["plan", str(path)]) == 1
    assert "does not stand: top falls;" in capsys.readouterr().out
    code, data = answer(capsys, "plan", str(path), "--anyway")
    assert code == 1
    assert data["counts"]["propped"] == 1


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--hands", "0"], "1 or more"),
        (["--robots", "left:-2,0,0:3"], "did you mean '--robot'?"),
        (["--scaffold-limit", "5"], "add --scaffold"),
        (["--scaffold-foot", "block-1"], "add --scaffold"),
        (["--scaffold", "rope", "--scaffold-foot", "block-1"], "is for struts"),
        (["--scaffold", "clamp", "--scaffold-length", "2"], "is for struts"),
        (["--robot", "a:0,0,0:3:50:7"], "NAME:X,Y,Z:REACH:PAYLOAD"),
        (["--robot", "a:0,0:3"], "write NAME:X,Y,Z, or NAME:X,Y,Z:REACH:PAYLOAD"),
        (["--payload", "-1"], "payload"),
        (["--before", "block-1"], "FIRST:THEN"),
        (["--before", "block-1:block-7"], "no block is called 'block-7'"),
        (["--before", "block-1:block-2", "--before", "block-2:block-1"], "contradicts itself"),
        (["--order", "sideways"], "no block is called 'sideways'"),
        (["--sweep", "0.3,x"], "--sweep"),
        (["--turns", "--margins"], "--turns: takes no --scaffold, --margins"),
        (["--turns", "--hands", "1"], "1 robots cannot take turns"),
        (["--workers", "0"], "--workers"),
        (["--workers", "x"], "--workers"),
        (["--html", "plan.txt"], "--html"),
    ],
)
def test_bad_input_is_one_line(stack, capsys, arguments, words):
    assert main(["plan", stack, *arguments]) == 2
    told = capsys.readouterr()
    assert words in told.err
    assert told.err.count("\n") == 1


def test_a_load_case_of_the_file_can_be_chosen(tmp_path, capsys):
    path, pair = tmp_path / "cases.json", tower(3)
    dead = replace(LoadCase.gravity(pair), name="dead")
    pushed = replace(dead + LoadCase.point_load(pair, "block-2", (5e4, 0.0, 0.0)), name="pushed")
    io.write(io.Contents(pair, loads=(dead, pushed)), path)
    assert answer(capsys, "plan", str(path), "--case", "1.35*dead")[0] == 0
    assert answer(capsys, "plan", str(path), "--case", "pushed")[1]["steps"] == []
    assert main(["plan", str(path), "--case", "wind"]) == 2
    assert "no load case is called 'wind'" in capsys.readouterr().err


def test_a_person_reads_why_no_block_can_be_put_in(stack, capsys):
    assert main(["plan", stack, "--payload", "1"]) == 1
    first, why = capsys.readouterr().out.splitlines()[:2]
    assert first.startswith("NO PLAN")
    assert why.startswith("payload 1 kg, 2 hands: block-1, block-2, block-3 weigh up to 2400 kg;")


def test_a_work_file_has_no_block_that_lacks_one_that_no_robot_lifts(tmp_path, capsys):
    wall, work = tmp_path / "wall.json", tmp_path / "work.json"
    io.write(corbelled_wall(4, 2), wall)
    robots = ("--robot", "left:-1,-1,0:4:40", "--robot", "right:1,-1,0:4:40", "--work", str(work))
    code, told = answer(capsys, "plan", str(wall), *robots)
    assert code == 1
    assert told["verdict"] != "stable"
    assert told["asked"]["options"]["robots"] == "left, right"
    assert told["notes"][0].startswith("payload 40 kg:")
    assert told["notes"][0].endswith(
        "weigh up to 43.2 kg; give a robot with a payload of 43.2 kg that reaches them"
    )
    done = json.loads(work.read_text())
    placed = [one["name"] for one in done["placements"]]
    assert placed == ["c01-b00", "c01-b02"]  # the halves on the ground; all of c02 is too heavy
    assert done["notes"][0] == told["notes"][0]
    assert done["notes"][1].startswith("impossible: c03-b00, c03-b02: waiting for them")
    assert told["notes"][-len(done["notes"]) + 1 :] == done["notes"][1:]  # said, not only written


def test_files_that_there_is_no_plan_for_are_named(stack, tmp_path, capsys):
    page = tmp_path / "plan.html"
    assert main(["plan", stack, "--payload", "1", "--html", str(page)]) == 1
    assert "not written" in capsys.readouterr().out
    assert not page.exists()


def test_a_monolith_is_cut_until_every_block_is_free(tmp_path, capsys):
    path, out = tmp_path / "tower.json", tmp_path / "blocks.json"
    io.write(Assembly((box((1.0, 1.0, 3.0), name="tower"),), np.array([False])), path)
    assert main(["cut", str(path), "--blocks", "3", "--out", str(out), "--json"]) == 0
    data = json.loads(capsys.readouterr().out)
    assert data["free"]
    assert [one["kind"] for one in data["changes"]] == ["cut", "cut"]
    assert [
        f", {height}) m" in one["description"]
        for height, one in zip((1, 2), data["changes"], strict=True)
    ] == [True, True]
    assert io.read(out).assembly.names == ("c00-block", "c01-block", "c02-block")
    assert main(["cut", str(out)]) == 2
    assert "the file has 3 blocks" in capsys.readouterr().err


def test_scaffolding_is_compared_and_planned_with(tmp_path, capsys):
    path = tmp_path / "arch.json"
    io.write(arch(0.3, 5), path)
    table = tmp_path / "compared.csv"
    given = [str(path), "--friction", "0.6", "--hands", "1"]
    code = main(
        ["scaffold", *given, "--with", "clamp", "--order", "top", "--csv", str(table), "--json"]
    )
    rows = json.loads(capsys.readouterr().out)["compared"]
    assert code == 0
    assert [(row["support"], row["failed_stages"]) for row in rows] == [("clamp", 0)]
    assert table.read_text().startswith("support,order")
    assert main(["scaffold", *given, "--with", "rope", "--order", "top", "--limit", "1"]) == 1
    out = capsys.readouterr().out
    assert "rope: in no order tried does every stage stand within 1 N; use another kind or a" in out
    assert re.search(r"\n order +support +propped .* failed stages *\n", out)  # no message a row
    _, data = answer(capsys, "plan", *given, "--scaffold", "clamp")
    assert data["scaffolding"]["failed"] == []
    assert data["scaffolding"]["cost"] == pytest.approx(rows[0]["cost"])
    assert main(["plan", *given, "--scaffold", "strut", "--scaffold-foot", "nowhere"]) == 2
    assert "no block is called 'nowhere'" in capsys.readouterr().err
    code, data = answer(capsys, "plan", *given, "--scaffold", "strut")
    assert not any("asks for real ones" in one for one in data["notes"])
    assert code or any("drystone recut" in one for one in data["notes"])
    strut = data["scaffolding"]["items"][0]
    assert strut["block"] == data["props"][0]["block"]
    assert strut["limit"] is None
    assert strut["length"] == pytest.approx(math.dist(strut["head"], strut["foot"]))


def test_a_plan_says_which_step_needs_help_and_why(tmp_path, capsys):
    path = tmp_path / "arch.json"
    io.write(arch(0.3, 5), path)
    assert main(["plan", str(path), "--hands", "1", "--friction", "0.6"]) == 1
    told = " ".join(capsys.readouterr().out.split())
    _, data = answer(capsys, "plan", str(path), "--hands", "1", "--friction", "0.6")
    why = [step["why"] for step in data["steps"] if step["why"]]
    assert why
    for one in why[:3]:
        assert one in told


def test_struts_that_are_too_short_are_the_reason_that_is_told(tmp_path, capsys):
    path = tmp_path / "arch.json"
    io.write(arch(0.3, 5), path)
    short = ["--hands", "1", "--with", "strut", "--order", "top", "--length", "0.2"]
    assert main(["scaffold", str(path), "--friction", "0.6", *short]) == 1
    told = " ".join(capsys.readouterr().out.split())
    assert "m long, more than 0.2 m" in told
    assert main(["scaffold", str(path), "--with", "rope", "--length", "0.2"]) == 2
    assert "is for struts" in capsys.readouterr().err


def test_the_check_of_scaffolding_ends_with_the_time_limit_too(stack, monkeypatch):
    limits = []
    check = sequence.scaffolding
    monkeypatch.setattr(
        sequence,
        "scaffolding",
        lambda *given, **how: limits.append(how["time_limit_s"]) or check(*given, **how),
    )
    assert main(["plan", stack, "--scaffold", "strut", "--time-limit", "50"]) == 0
    assert limits == [50.0]


def test_blocks_are_held_only_where_each_has_a_robot_of_its_own(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Each of two stones holds the other; the second robot reaches none of them."""
    path = tmp_path / "arch.json"
    io.write(arch(0.25, 2), path)
    asked = ["plan", str(path), "--friction", "0.7", "--robot", "a:-1,0,0:5"]
    assert main([*asked, "--robot", "b:1,0,0:5"]) == 0
    capsys.readouterr()
    assert main([*asked, "--robot", "b:9,0,0:2.2"]) == 1
    assert "1 free, 0 held, 1 propped" in capsys.readouterr().out
