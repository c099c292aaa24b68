"""DAE: nodes of a scene, their geometries and transformations, units and axes."""

from pathlib import Path

import numpy as np
import pytest

import drystone
from drystone import Block, FormatError, Verdict, check, io
from drystone.models import box

CUBE = box((1.0, 1.0, 1.0))
UPPER = "<translate>0 0 1</translate>"


def faces(block: Block, kind: str = "polylist") -> str:
    loops = [list(face) for face in block.faces]
    lists = [" ".join(f"{i} 0" for i in loop) for loop in loops]
    if kind == "polylist":
        count = " ".join(str(len(loop)) for loop in loops)
        inner = f"<vcount>{count}</vcount><p>{' '.join(lists)}</p>"
    elif kind == "polygons":
        inner = "".join(f"<p>{one}</p>" for one in lists)
    elif kind == "triangles":
        cut = [t for a, b, c, d in loops for t in ((a, b, c), (a, c, d))]
        inner = f"<p>{' '.join(f'{i} 0' for t in cut for i in t)}</p>"
    elif kind == "trifans":
        inner = "".join(f"<p>{one}</p>" for one in lists)
    else:
        strips = [(a, b, d, c) for a, b, c, d in loops]
        inner = "".join(f"<p>{' '.join(f'{i} 0' for i in s)}</p>" for s in strips)
    inputs = '<input semantic="VERTEX" source="#v" offset="0"/>'
    inputs += '<input semantic="NORMAL" source="#n" offset="1"/>'
    return f"<{kind}>{inputs}{inner}</{kind}>"


def text(
    nodes: str, up: str = "Z_UP", unit: str = '<unit meter="1"/>', kind: str = "polylist"
) -> str:
    points = " ".join(str(x) for x in CUBE.vertices.ravel())
    return (
        '<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema">'
        f"<asset>{unit}<up_axis>{up}</up_axis></asset>"
        f'<library_geometries><geometry id="g"><mesh><source id="s"><float_array>{points}'
        '</float_array><technique_common><accessor stride="3"/></technique_common></source>'
        '<vertices id="v"><input semantic="POSITION" source="#s"/></vertices>'
        f"{faces(CUBE, kind)}</mesh></geometry></library_geometries>"
        f'<library_visual_scenes><visual_scene id="w">{nodes}</visual_scene>'
        "</library_visual_scenes>"
        '<scene><instance_visual_scene url="#w"/></scene></COLLADA>'
    )


def node(name: str, moves: str = "", inner: str = '<instance_geometry url="#g"/>') -> str:
    return f'<node name="{name}">{moves}{inner}</node>'


def read(folder: Path, content: str) -> io.Contents:
    path = folder / "model.dae"
    path.write_text(content, encoding="utf-8")
    return io.read_file(path)


@pytest.mark.parametrize("kind", ["polylist", "polygons", "triangles", "trifans", "tristrips"])
def test_nodes_of_a_scene_are_blocks(tmp_path: Path, kind: str) -> None:
    found = read(tmp_path, text(node("base") + node("top", UPPER), kind=kind)).assembly
    assert found.names == ("base", "top")
    assert [len(block.faces) for block in found.blocks] == [6, 6]
    assert found.blocks[1].centroid == pytest.approx(CUBE.centroid + np.array([0.0, 0.0, 1.0]))
    model = drystone.read(tmp_path / "model.dae", supports="base")
    assert check(model).verdict is Verdict.STABLE


def test_transformations_follow_each_other_and_nodes_their_parents(tmp_path: Path) -> None:
    turn = "<translate>5 0 0</translate><rotate>0 0 1 90</rotate><scale>2 1 1</scale>"
    mirror = "<matrix>-1 0 0 0  0 1 0 0  0 0 1 0  0 0 0 1</matrix>"
    found = read(tmp_path, text(node("outer", turn, node("inner", mirror)))).assembly.blocks[0]
    matrix = np.array([[0.0, -1.0, 0.0], [-2.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    assert found.centroid == pytest.approx(matrix @ CUBE.centroid + [5.0, 0.0, 0.0])
    assert found.volume == pytest.approx(2.0)


@pytest.mark.parametrize("up", ["X_UP", "Y_UP", "Z_UP"])
@pytest.mark.parametrize(("meter", "unit"), [("0.001", "mm"), ("0.0254", "in"), ("1", "m")])
def test_the_axis_and_the_unit_of_the_file_are_used(
    tmp_path: Path, up: str, meter: str, unit: str
) -> None:
    long = "<scale>{} {} {}</scale>".format(*(3 if axis == up[0] else 1 for axis in "XYZ"))
    found = read(tmp_path, text(node("a", long), up, f'<unit name="{unit}" meter="{meter}"/>'))
    low, high = found.assembly.bounds[0]
    assert high - low == pytest.approx(float(meter) * np.array([1.0, 1.0, 3.0]))


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("<COLLADA", "is no XML"),
        ("<robot/>", "is XML, but no COLLADA"),
        ('<!DOCTYPE a [<!ENTITY b "c">]><COLLADA/>', "defines entities"),
        (text(""), "shows no mesh"),
        (text(node("a", inner='<instance_geometry url="#x"/>')), "geometry 'x': is no mesh"),
        (text(node("a", "<scale>1 1</scale>")), "node 'a': 'scale' is '1 1'; write 3 numbers"),
        (text(node("a")).replace("<vcount>4", "<vcount>x"), "no number"),
        (text(node("a")).replace("<p>", "<p>99 0 "), "vertex that does not exist"),
        (text(node("a"), "Q_UP"), "its up axis is 'Q_UP'"),
        (text(node("a"), unit='<unit meter="0.7"/>'), r"its unit is 0\.7 m"),
        (text('<node id="n"><instance_node url="#n"/></node>'), "is in itself"),
    ],
)
def test_what_cannot_be_read_is_told_in_one_line(tmp_path: Path, content: str, words: str) -> None:
    with pytest.raises(FormatError, match=words) as caught:
        read(tmp_path, content)
    assert "\n" not in str(caught.value)


def test_geometries_may_use_the_same_names_inside(tmp_path: Path) -> None:
    content = text(node("a") + node("b", "", '<instance_geometry url="#h"/>'))
    start, end = content.index('<geometry id="g">'), content.index("</library_geometries>")
    other = content[start:end].replace('id="g"', 'id="h"')
    points = " ".join(str(x) for x in (CUBE.vertices + 5.0).ravel())
    first, last = other.index("<float_array>") + 13, other.index("</float_array>")
    content = content[:end] + other[:first] + points + other[last:] + content[end:]
    one, two = read(tmp_path, content).assembly.blocks
    assert two.centroid - one.centroid == pytest.approx([5.0, 5.0, 5.0])
