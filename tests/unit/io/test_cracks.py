"""Joints that are cut out as cracks."""

from pathlib import Path

import pytest

import drystone
from drystone import InputError, check
from drystone.cli import main
from drystone.models import dome, tower


def head_joints(rings: int) -> list[str]:
    return [f"r{i:02d}-*:r{i:02d}-*" for i in range(rings)]


def test_a_dome_stands_with_cracks_up_to_its_haunches_and_falls_in_where_they_reach_its_eye() -> (
    None
):
    assembly = dome(slices=6, rings=4)
    low = check(assembly, friction=0.7, crack=head_joints(2))
    assert low.stable
    assert low.contacts.count == check(assembly, friction=0.7).contacts.count - 12
    told = low.model.notes[-1].partition(": ")
    assert told[0] == "12 joints cut out as cracks, which carry nothing"
    assert told[2].startswith("r00-")
    assert told[2].endswith("and 9 more")
    assert check(assembly, friction=0.7, crack=head_joints(4)).falls


def test_the_command_cuts_joints_out_and_says_so(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "tower.json"
    drystone.write(tower(3), path)
    assert main(["check", str(path), "--crack", "block-0:block-1"]) == 1
    assert (
        "1 joint cut out as cracks, which carry nothing: block-0-block-1" in capsys.readouterr().out
    )
    assert check(path).stable


@pytest.mark.parametrize(
    ("crack", "told"),
    [("block-1", "is not BLOCKS:BLOCKS"), ("block-0:block-2", "no joint is between")],
)
def test_a_crack_is_between_blocks_that_touch(crack: str, told: str) -> None:
    with pytest.raises(InputError, match=told):
        check(tower(3), crack=crack)
