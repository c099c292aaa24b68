import numpy as np
import pytest

from drystone import InputError
from drystone.shells import Layout, barrel_vault, build_shell, dome, patch_from_function
from drystone.shells.courses import lay_bond, lay_courses
from drystone.shells.pattern import lay_pattern


def pattern_of(patch, *, courses=4, blocks=4, wedge=0.0):
    laid = lay_courses(patch, count=courses)
    return lay_pattern(laid, lay_bond(laid, blocks=blocks), wedge=wedge)


def areas(pattern):
    """Signed area of every cell in (u, v)."""
    out = []
    for cell in pattern.cells:
        u, v = pattern.uv[list(cell)].T
        if v.max() - v.min() > 0.5:  # across the closure of a ring
            v = np.where(v < 0.5, v + 1.0, v)
        out.append(0.5 * float((u * np.roll(v, -1) - v * np.roll(u, -1)).sum()))
    return np.array(out)


def edges(pattern):
    """How often every edge is used, in its direction."""
    count = {}
    for cell in pattern.cells:
        for edge in zip(cell, (*cell[1:], cell[0]), strict=True):
            count[edge] = count.get(edge, 0) + 1
    return count


BARREL = barrel_vault(6.0, 6.0).patches[0]
DOME = dome().patches[0]
FAN = patch_from_function(
    lambda u, v: np.stack([(3.0 + 4.0 * v) * (u - 0.5), 6.0 * v, 0.0 * u], axis=-1), name="fan"
)


@pytest.mark.parametrize("wedge", [-0.3, 0.0, 0.3])
@pytest.mark.parametrize("patch", [BARREL, DOME, FAN], ids=lambda p: p.name)
def test_cells_fill_the_patch_without_gap_or_overlap(patch, wedge):
    signed = areas(pattern_of(patch, wedge=wedge))
    assert np.isclose(abs(signed.sum()), 1.0)
    assert (np.sign(signed) == np.sign(signed[0])).all()


@pytest.mark.parametrize("patch", [BARREL, DOME, FAN], ids=lambda p: p.name)
def test_neighbours_share_whole_edges(patch):
    """No T-junction: every inner edge is run once in each direction."""
    used = edges(pattern_of(patch, wedge=0.2))
    assert set(used.values()) == {1}
    alone = [edge for edge in used if edge[::-1] not in used]
    on_border = set()
    for run, _ in pattern_of(patch, wedge=0.2).borders.values():
        on_border |= set(run.tolist())
    assert all(a in on_border and b in on_border for a, b in alone)


def test_a_block_in_the_middle_is_a_hexagon():
    pattern = pattern_of(BARREL)
    assert len(pattern.cells[pattern.names.index("c01-b01")]) == 6


def test_half_blocks_stand_at_the_ends_of_every_other_course():
    pattern = pattern_of(BARREL)
    per_course = np.bincount(pattern.course)
    assert per_course.tolist() == [4, 5, 4, 5]


def test_names_tell_course_and_place():
    pattern = pattern_of(BARREL)
    for name, course, place in zip(pattern.names, pattern.course, pattern.position, strict=True):
        assert name == f"c{course:02d}-b{place:02d}"


def test_a_wedge_raises_the_bed_under_the_joints_of_the_course_above():
    plain, wedged = pattern_of(BARREL), pattern_of(BARREL, wedge=0.2)
    low = wedged.heads[:, 0]
    inner = wedged.inner[low] & (wedged.uv[low, 1] > 0.0) & (wedged.uv[low, 1] < 1.0)
    rise = wedged.uv[low[inner], 0] - plain.uv[low[inner], 0]
    assert np.allclose(rise, 0.2 * 0.25)


def test_a_wedge_of_each_bed_line_moves_only_that_line():
    plain, wedged = pattern_of(BARREL), pattern_of(BARREL, wedge=[0.0, 0.2, 0.0])
    moved = ~np.isclose(plain.uv[:, 0], wedged.uv[:, 0])
    assert moved.any()
    assert np.allclose(plain.uv[moved, 0], 0.5)


def test_a_wedge_may_be_a_function_of_the_place():
    plain = pattern_of(BARREL)
    wedged = pattern_of(BARREL, wedge=lambda u, v: np.where(v > 0.5, 0.2, 0.0))
    moved = ~np.isclose(plain.uv[:, 0], wedged.uv[:, 0])
    assert moved.any()
    assert (plain.uv[moved, 1] > 0.5).all()


@pytest.mark.parametrize("wedge", [0.5, -0.6])
def test_a_wedge_that_turns_a_block_inside_out_names_the_block(wedge):
    with pytest.raises(InputError, match=r"block 'c00-b00'.*turns blocks inside out"):
        pattern_of(BARREL, wedge=wedge)


def test_wedges_must_be_one_per_bed_line():
    with pytest.raises(InputError, match="2 wedges for 3 bed lines"):
        pattern_of(BARREL, wedge=[0.1, 0.1])


def test_zero_wedge_gives_plain_bed_joints():
    shell = build_shell(barrel_vault(6.0, 6.0), Layout(courses=4, blocks=4))
    heights = {round(float(z), 9) for z in shell.mesh.point[shell.mesh.inner, 2]}
    assert len(heights) == 2  # three bed lines, symmetric about the crown


def test_a_wedge_is_less_where_head_joints_come_close():
    """Of two joints 0.2 of a block apart, each shifts its bed by 0.4 of the wedge."""
    courses = lay_courses(barrel_vault().patches[0], count=2)
    joints = [np.array([0.0, 0.5, 1.0]), np.array([0.0, 0.4, 0.9, 1.0])]
    pattern = lay_pattern(courses, joints, wedge=0.2)
    on = np.flatnonzero(pattern.inner)
    shift = dict(zip(pattern.uv[on, 1].round(9).tolist(), pattern.uv[on, 0] - 0.5, strict=True))
    assert shift[0.4] == pytest.approx(0.2 * 0.5 * 2.0 * 0.1 / 0.5, rel=1e-3)
    assert shift[0.5] == pytest.approx(-0.2 * 0.5 * 2.0 * 0.1 / 0.5, rel=1e-3)
    assert shift[0.9] == pytest.approx(0.2 * 0.5 * 2.0 * 0.1 / 0.5, rel=1e-3)


def test_no_bed_of_a_changing_bond_is_steeper_than_in_a_regular_one():
    def steepest(blocks):
        courses = lay_courses(barrel_vault(6.0, 6.0).patches[0], count=12)
        bond = lay_bond(courses, blocks=blocks)
        pattern = lay_pattern(courses, bond, wedge=0.2)
        edges = [
            pair
            for cell in pattern.cells
            for pair in zip(cell, (*cell[1:], cell[0]), strict=True)
            if not {tuple(sorted(pair))} & {tuple(sorted(h)) for h in pattern.heads.tolist()}
        ]
        a, b = pattern.uv[np.array(edges)].transpose(1, 0, 2)
        inner = np.abs(a[:, 1] - b[:, 1]) > 1e-9
        return float((np.abs(a - b)[inner, 0] / np.abs(a - b)[inner, 1]).max())

    assert steepest([6, 7] * 6) <= steepest(7) * (1.0 + 1e-9)
