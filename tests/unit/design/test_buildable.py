"""Shells built with less help, checked and planned again from their files."""

import json
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import pytest

import drystone
from benchmarks.niche import NICHE, niche_shape
from drystone import InputError, design
from drystone.base.workers import LocalWorkers
from drystone.cli import main
from drystone.cli.waiting import UNDER_WAY
from drystone.design import BuildableOptions, Help, make_buildable
from drystone.design.buildable import (
    course_of,
    levels_of,
)
from drystone.sequence import Order, PlanOptions, Rules, plan
from drystone.shells import (
    Ground,
    Layout,
    Shell,
    ShellBody,
    barrel_vault,
    build_shell,
    dome,
    find_form,
    three_vault_plan,
)

BY_COURSE = PlanOptions(rules=Rules(order=Order.COURSE))


def vault(wedges: list[float]) -> Shell:
    layout, body = NICHE
    return build_shell(niche_shape(), replace(layout, wedge=wedges), body)


def test_the_published_vault_needs_no_help_with_deep_wedges_below_two_of_four_courses(
    tmp_path: Path,
) -> None:
    """As `make_buildable` finds it: (0.02, 0.02, 0.3, 0.1), in half a minute."""
    path = tmp_path / "vault.json"
    drystone.write(vault([0.02, 0.02, 0.3, 0.1]).model(friction=0.6), path)
    model = drystone.read(path)
    assert drystone.check(model).stable
    assert not any(Help.of(plan(model, options=BY_COURSE)))


def test_wedges_are_searched_course_by_course_until_no_block_needs_help() -> None:
    shape, layout = dome(3.0, 1.5), Layout(courses=3, blocks=5)
    body = ShellBody(thickness=0.5, ground=Ground.SPRINGERS)
    wedges = BuildableOptions(wedges=(0.02, 0.4))
    with ThreadPoolExecutor(2) as executor:
        found = make_buildable(shape, layout, body, options=wedges, executor=executor)
    assert found.before is not None
    assert found.before.blocks == 2
    assert found.free
    assert found.layout is not None
    assert found.layout.wedge == (0.02, 0.4)
    made = plan(build_shell(shape, found.layout, body).model(friction=0.6), options=BY_COURSE)
    assert made.stable
    assert made.counts["free"] == 10


def test_courses_that_close_between_two_springings_are_gone_through_from_both() -> None:
    body = ShellBody(thickness=0.6, ground=Ground.SPRINGERS)
    shell = build_shell(barrel_vault(6.0, 6.0), Layout(courses=5, blocks=2), body)
    course, level = course_of(shell), levels_of(shell)
    assert [level[course == c].max() for c in range(5)] == [0.0, 1.0, 2.0, 1.0, 0.0]


def test_courses_that_spring_from_the_ground_are_gone_through_from_both() -> None:
    shell = build_shell(barrel_vault(6.0, 6.0), Layout(courses=5, blocks=2))
    course, level = course_of(shell), levels_of(shell)
    assert [level[course == c].max() for c in range(5)] == [1.0, 2.0, 3.0, 2.0, 1.0]


def three_vaults() -> Shell:
    shape = find_form(three_vault_plan(), height=1.8, thickness=0.4).shape
    body = ShellBody(ground=Ground.SPRINGERS)
    return build_shell(shape, Layout(courses=3, width=2.5, wedge=0.02), body)


def test_arches_between_fixed_springers_are_built_one_after_the_other(tmp_path: Path) -> None:
    """Three vaults from leg to leg: no block is propped, and every stage stands from the file."""
    shell = three_vaults()
    roles = {block.name: block.metadata["role"] for block in shell.assembly.blocks}
    for patch in range(3):
        for course in range(3):
            own = sorted(name for name in roles if name.startswith(f"p{patch}-c{course:02d}-"))
            assert [roles[own[0]], roles[own[-1]]] == ["springer", "springer"]
    path = tmp_path / "vaults.json"
    drystone.write(shell.model(friction=0.6), path)
    made = plan(drystone.read(path), options=BY_COURSE)
    course = {b.name: b.metadata["course"] for b in shell.assembly.blocks}
    assert [course[name] for name in made.order] == sorted(course[name] for name in made.order)
    assert made.stable
    assert Help.of(made).propped == 0


def test_blocks_that_are_placed_already_are_not_planned() -> None:
    shell = build_shell(
        barrel_vault(6.0, 6.0), Layout(courses=5, blocks=2), ShellBody(thickness=0.6)
    )
    course = course_of(shell)
    names = shell.assembly.names
    placed = tuple(name for name, c in zip(names, course, strict=True) if c in (0, 1, 3, 4))
    rules = Rules(order=Order.COURSE, placed=placed)
    made = plan(shell.model(friction=0.7), options=PlanOptions(rules=rules, anyway=True))
    assert not set(made.order) & set(placed)
    assert len(made.order) + len(placed) == len(shell.voussoirs)


@pytest.mark.parametrize(
    "given",
    [{"wedges": ()}, {"wedges": (0.2, 0.1)}, {"wedges": (0.1, 0.6)}, {"wedges": (0.1, 0.1)},
     {"hands": 0}],
)  # fmt: skip
def test_options_that_make_no_sense_are_refused(given: dict[str, object]) -> None:
    with pytest.raises(InputError):
        BuildableOptions(**given)  # type: ignore[arg-type]


def test_a_layout_that_cannot_be_built_is_told_with_its_reason() -> None:
    with pytest.raises(InputError, match="no layout was planned"):
        make_buildable(
            barrel_vault(6.0, 6.0), Layout(courses=5, blocks=2), ShellBody(thickness=9.0)
        )
    with pytest.raises(InputError, match="stopped"):
        make_buildable(barrel_vault(6.0, 6.0), Layout(courses=5, blocks=2), stop=lambda: True)


def test_a_search_that_is_stopped_before_its_first_plan_says_so(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    body = ShellBody(thickness=0.4)

    def interrupted(*given: object, **how: object) -> None:
        work = UNDER_WAY.get()
        assert work is not None
        work.interrupted = True
        assert how["executor"] == LocalWorkers(2)
        make_buildable(barrel_vault(4.0, 2.0, 2.0), Layout(courses=3), body, stop=lambda: True)

    with pytest.raises(InputError, match="stopped before its first plan; give it time"):
        make_buildable(barrel_vault(4.0, 2.0, 2.0), Layout(courses=3), body, time_limit_s=0.0)
    monkeypatch.setattr(design, "make_buildable", interrupted)
    assert main(["shell", "barrel", "--courses", "3", "--buildable", "--workers", "2"]) == 130
    assert "interrupted; nothing was written" in capsys.readouterr().err


def test_the_command_takes_a_wedge_for_each_course(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "shell.json"
    words = ["shell", "dome", "--courses", "3", "--blocks", "8", "--eye", "2", "--thickness", "0.5"]
    assert main([*words, "--wedge=0.1,0.2", "--out", str(out), "--json"]) == 0
    capsys.readouterr()
    assert main([*words, "--wedge", "0.1,0.2,0.1"]) == 2
    assert "3 wedges for 2 bed lines" in capsys.readouterr().err
    assert main([*words, "--wedge", "deep"]) == 2
    capsys.readouterr()
    words[3], words[5] = "2", "6"
    code = main([*words, "--buildable", "--out", str(out), "--json"])
    told = json.loads(capsys.readouterr().out)["buildable"]
    assert code == 0
    assert list(told["help"].values()) <= list(told["before"].values())
    assert len(told["wedges"]) == 1
    assert drystone.check(drystone.read(out, friction=0.6)).stable
    assert main([*words, "--straight", "--buildable"]) == 2
