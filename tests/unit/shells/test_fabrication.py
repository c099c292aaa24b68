import csv
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest

from benchmarks.sample_shells import sample_shell
from drystone import InputError, read, write
from drystone.shells import (
    Layout,
    ShellBody,
    barrel_vault,
    block_frame,
    build_shell,
    dome,
    flat_faces,
    own_frame,
    schedule,
    write_blocks,
    write_unrolled,
)
from drystone.shells.materialise import HOOK, cell_faces

SHELL = build_shell(
    barrel_vault(6.0, 6.0, 2.0), Layout(courses=9, blocks=4, wedge=0.2), ShellBody(thickness=0.3)
)


def angles(row: str) -> np.ndarray:
    return np.array([float(one) for one in row.split()])


def row_of(shell, name: str) -> dict:
    return next(row for row in schedule(shell) if row["block"] == name)


def test_a_block_in_its_own_frame_has_its_centre_at_the_origin():
    block = own_frame(SHELL, "c03-b02")
    assert np.allclose(block.centroid, 0.0, atol=1e-12)
    assert block.volume == pytest.approx(SHELL.assembly.volume[SHELL.assembly.index("c03-b02")])


def test_frames_are_right_handed_and_look_out():
    for i in SHELL.voussoirs.tolist():
        axes, origin = block_frame(SHELL, i)
        assert np.allclose(axes @ axes.T, np.eye(3), atol=1e-12)
        assert np.linalg.det(axes) > 0.0
        assert axes[2] @ (origin - [0.0, origin[1], -1.25]) > 0.0  # away from the axis


def test_the_schedule_has_a_row_per_voussoir():
    table = schedule(SHELL)
    assert table["block"].tolist() == [SHELL.assembly.names[i] for i in SHELL.voussoirs]
    assert table["volume"].sum() == pytest.approx(SHELL.volume)
    assert table["mass"].sum() == pytest.approx(SHELL.volume * 2400.0)


def test_the_corners_of_a_block_turn_once_around():
    """Sum of the inner angles of a polygon; nearly, since the side faces lean a little."""
    for row in schedule(SHELL):
        assert angles(row["corners"]).sum() == pytest.approx(180.0 * (row["joints"] - 2), abs=3.0)


def test_bed_joints_of_a_plain_vault_are_bevelled_by_half_the_angle_of_a_course():
    shell = build_shell(
        barrel_vault(6.0, 6.0), Layout(courses=9, blocks=4), ShellBody(thickness=0.3)
    )
    row = row_of(shell, "c03-b01")
    assert np.unique(angles(row["bevels"])).tolist() == [80.0, 90.0]


def test_the_schedule_as_csv(tmp_path):
    schedule(SHELL).to_csv(tmp_path / "schedule.csv")
    with (tmp_path / "schedule.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == len(SHELL.voussoirs)
    row = next(r for r in rows if r["block"] == "c03-b02")
    i = SHELL.assembly.index("c03-b02")
    assert float(row["volume [m3]"]) == pytest.approx(SHELL.assembly.volume[i], abs=1e-6)
    assert len(row["bevels [deg]"].split()) == int(row["joints"])


def test_block_files_hold_one_block_each(tmp_path):
    paths = write_blocks(SHELL, tmp_path / "blocks")
    assert len(paths) == len(SHELL.voussoirs)
    model = read(tmp_path / "blocks" / "c03-b02.obj")
    assert model.assembly.names == ("c03-b02",)
    assert model.assembly.volume[0] == pytest.approx(
        SHELL.assembly.volume[SHELL.assembly.index("c03-b02")], rel=1e-9
    )


def test_blocks_may_be_written_as_stl(tmp_path):
    paths = write_blocks(SHELL, tmp_path, suffix=".stl")
    assert {path.suffix for path in paths} == {".stl"}
    (volume,) = read(tmp_path / "c03-b02.stl").assembly.volume
    whole = SHELL.assembly.volume[SHELL.assembly.index("c03-b02")]
    assert volume == pytest.approx(whole, rel=5e-3)  # warped outer faces are cut into triangles


def test_flat_faces_keep_lengths_and_areas():
    i = SHELL.assembly.index("c03-b02")
    for face in flat_faces(SHELL, i):
        beside = {SHELL.assembly.names[k] for k in (i,)} | {face.neighbour}
        solid = [
            joint.corners
            for joint in SHELL.contacts
            if {SHELL.assembly.names[i] for i in joint.blocks} == beside
        ]
        lengths = sorted(np.linalg.norm(face.corner - np.roll(face.corner, 1, axis=0), axis=1))
        assert any(
            np.allclose(lengths, sorted(np.linalg.norm(c - np.roll(c, 1, axis=0), axis=1)))
            for c in solid
        )


def test_unrolled_faces_as_svg(tmp_path):
    write_unrolled(SHELL, tmp_path / "joints.svg", blocks=["c03-b02", "c03-b03"])
    root = ET.parse(tmp_path / "joints.svg").getroot()
    name = "{http://www.w3.org/2000/svg}"
    assert len(root.findall(f".//{name}polygon")) == 12
    assert root.attrib["width"].endswith("mm")  # to print and to cut; a screen is smaller
    style = root.find(f"{name}style")
    assert style is not None
    assert "@media screen { svg { width: 100vw; height: auto;" in style.text
    labels = {text.text for text in root.findall(f".//{name}text")}
    assert "c03-b02 | c03-b03" in labels
    assert "c03-b03 | c03-b02" in labels


def test_unrolled_faces_do_not_overlap(tmp_path):
    import shapely

    write_unrolled(SHELL, tmp_path / "joints.svg", blocks=["c03-b02", "c04-b01"])
    root = ET.parse(tmp_path / "joints.svg").getroot()
    polygons = [
        shapely.Polygon([tuple(map(float, p.split(","))) for p in element.get("points").split()])
        for element in root.iter("{http://www.w3.org/2000/svg}polygon")
    ]
    assert shapely.unary_union(polygons).area == pytest.approx(sum(p.area for p in polygons))


def test_unrolled_faces_as_dxf(tmp_path):
    write_unrolled(SHELL, tmp_path / "joints.dxf", blocks=["c03-b02"])
    lines = (tmp_path / "joints.dxf").read_text().split("\n")
    pairs = list(zip(lines[0::2], lines[1::2], strict=False))
    assert pairs[0] == ("0", "SECTION")
    assert pairs[-1] == ("0", "EOF")
    assert sum(pair == ("0", "POLYLINE") for pair in pairs) == 6
    assert sum(pair == ("0", "VERTEX") for pair in pairs) == 24
    assert sum(pair == ("0", "SEQEND") for pair in pairs) == 6


def test_another_suffix_is_refused(tmp_path):
    with pytest.raises(InputError, match=r"use .svg or .dxf"):
        write_unrolled(SHELL, tmp_path / "joints.png")
    assert not list(tmp_path.iterdir())


def test_an_unknown_block_is_refused(tmp_path):
    with pytest.raises(InputError, match="no block is called 'c99-b00'"):
        write_unrolled(SHELL, tmp_path / "joints.svg", blocks=["c99-b00"])


@pytest.mark.parametrize("suffix", [".stl", ".glb"])
def test_triangles_in_a_file_enclose_the_blocks_of_the_schedule(tmp_path: Path, suffix: str):
    """The inner and outer faces of a doubly curved shell are warped, of some blocks concave too."""
    assembly = sample_shell("form-found", 40).assembly
    write(assembly, tmp_path / f"shell{suffix}")
    again = read(tmp_path / f"shell{suffix}").assembly
    assert again.names == assembly.names
    assert again.volume == pytest.approx(assembly.volume, rel=1e-5)
    assert again.centroid == pytest.approx(assembly.centroid, abs=1e-6)


@pytest.mark.parametrize("joggle_deg", [15.0, -10.0])
def test_corner_angles_of_a_hooked_bed_are_those_of_its_section(joggle_deg: float):
    """The turns of the section on one side of the joint, and their complement on the other."""
    body = ShellBody(thickness=0.3, joggle_deg=joggle_deg)
    shell = build_shell(barrel_vault(6.0, 6.0), Layout(courses=9, blocks=4), body)
    row = row_of(shell, "c03-b01")
    slope = np.tan(np.deg2rad(abs(joggle_deg)))
    section = np.array([(-1.0, 0.0), *HOOK, (1.0, 0.0)]) * [1.0, slope]
    way = np.diff(section, axis=0)
    turn = np.rad2deg(np.unwrap(np.arctan2(way[:, 1], way[:, 0])))
    inner = np.diff(turn)
    expected = {90.0, 180.0, *(180.0 + inner), *(180.0 - inner)}
    assert np.unique(np.round(angles(row["corners"]), 4)) == pytest.approx(
        sorted(expected), abs=1e-4
    )


def test_corner_angles_are_those_between_the_faces():
    """On a dome no side face is square to the block; compared with the angle of their planes."""
    shell = build_shell(dome(3.0, 0.5), Layout(courses=4, blocks=8, wedge=0.2))
    i = shell.assembly.index("c01-b03")
    faces = cell_faces(shell.mesh, shell.pins, shell.mesh.cells[i])[2]
    normal = []
    for face in faces:
        a, b, c = shell.pins.point[list(face[:3])]
        normal.append(np.cross(b - a, c - a) / np.linalg.norm(np.cross(b - a, c - a)))
    after = normal[1:] + normal[:1]
    convex = [180.0 - np.rad2deg(np.arccos(n @ m)) for n, m in zip(normal, after, strict=True)]
    corner = angles(row_of(shell, "c01-b03")["corners"])
    bent = np.where(corner > 180.0, 360.0 - corner, corner)
    assert bent == pytest.approx(np.array(convex), abs=1e-5)
