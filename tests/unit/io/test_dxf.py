"""DXF as CAD programs write it: outlines of a section, bodies in space, layers, insertions."""

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import drystone
from drystone import FormatError, InputError, Verdict, check, io
from drystone.cli import main

Tags = list[tuple[int, Any]]


def text(
    entities: Iterable[Tags], units: int = 0, blocks: Sequence[Tags] = (), tables: Any = ()
) -> str:
    tags: Tags = [(0, "SECTION"), (2, "HEADER"), (9, "$EXTMIN"), (10, 1e20), (20, 1e20)]
    tags += [(9, "$INSUNITS"), (70, units), (0, "ENDSEC")]
    for name, group in (("TABLES", tables), ("BLOCKS", blocks), ("ENTITIES", entities)):
        tags += [(0, "SECTION"), (2, name), *(tag for one in group for tag in one), (0, "ENDSEC")]
    return "".join(f"{code:3d}\n{value}\n" for code, value in [*tags, (0, "EOF")])


def light(corners: Any, layer: str = "0", closed: int = 1, **more: Any) -> Tags:
    tags: Tags = [(0, "LWPOLYLINE"), (8, layer), (90, len(corners)), (70, closed)]
    tags += [(int(code[1:]), value) for code, value in more.items()]
    for x, y, *bulge in corners:
        tags += [(10, x), (20, y), *((42, b) for b in bulge)]
    return tags


def heavy(corners: Any, flags: int = 1, layer: str = "0") -> list[Tags]:
    vertices: list[Tags] = [
        [(0, "VERTEX"), (8, layer), (10, x), (20, y), (30, 0), *((42, b) for b in bulge)]
        for x, y, *bulge in corners
    ]
    return [[(0, "POLYLINE"), (8, layer), (66, 1), (70, flags)], *vertices, [(0, "SEQEND")]]


def square(x: float, y: float, size: float = 1.0) -> list[tuple[float, float]]:
    return [(x, y), (x + size, y), (x + size, y + size), (x, y + size)]


def arch(count: int = 7, inner: float = 2.0, outer: float = 2.5) -> list[list[tuple[float, ...]]]:
    """Voussoirs of a half circle with arcs above and below."""
    bulge = float(np.tan(np.pi / count / 4))
    stones = []
    for i in range(count):
        a, b = np.pi * i / count, np.pi * (i + 1) / count
        at = [
            (r * np.cos(t), r * np.sin(t))
            for r, t in [(inner, a), (outer, a), (outer, b), (inner, b)]
        ]
        stones.append([(*at[0], 0), (*at[1], bulge), (*at[2], 0), (*at[3], -bulge)])
    return stones


def read(folder: Path, content: str, **options: Any) -> io.Contents:
    path = folder / "model.dxf"
    path.write_text(content, encoding="utf-8")
    return io.read_file(path, **options)


def test_a_section_of_an_arch_is_a_model_in_one_command(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    stones = [light(one, "arch") for one in arch()]
    feet = [
        light([(x, -0.5), (x + 1, -0.5), (x + 1, 0), (x, 0)], "supports") for x in (1.75, -2.75)
    ]
    path = tmp_path / "bridge.dxf"
    path.write_text(text([*stones, *feet], units=6), encoding="ascii")
    assert main(["check", str(path), "--thickness", "450mm", "--friction", "0.7"]) == 0
    assert "5.5 x 0.45 x 3 m" in capsys.readouterr().out
    model = drystone.read(path, thickness=0.45)
    assert model.assembly.names[0] == "arch-0"
    assert model.assembly.blocks[0].metadata["layer"] == "arch"
    assert model.assembly.fixed.tolist() == [False] * 7 + [True] * 2
    assert model.contacts.count == 8
    volume = sum(block.volume for block in model.assembly.blocks[:7])
    assert volume == pytest.approx(0.45 * np.pi / 2 * (2.5**2 - 2.0**2), rel=2e-3)


@pytest.mark.parametrize(
    ("code", "scale"), [(0, 1.0), (1, 0.0254), (2, 0.3048), (4, 1e-3), (5, 1e-2), (6, 1.0)]
)
def test_lengths_are_in_the_units_of_the_drawing_and_a_section_is_1_m_thick(
    tmp_path: Path, code: int, scale: float
) -> None:
    contents = read(tmp_path, text([light(square(0, 0, 2.0))], units=code))
    low, high = contents.assembly.bounds[0]
    assert high - low == pytest.approx([2 * scale, 1.0, 2 * scale])
    assert "no thickness is given: its blocks are 1 m thick (--thickness)" in contents.notes
    low, high = read(
        tmp_path, text([light(square(0, 0))]), units="cm", thickness=2.0
    ).assembly.bounds[0]
    assert high - low == pytest.approx([0.01, 2.0, 0.01])


def test_old_polylines_circles_and_mirrored_outlines_are_outlines(tmp_path: Path) -> None:
    (stone, *_) = arch()
    mirrored = [(-x - 20, y, -b) for x, y, b in stone]
    entities = [*heavy(stone), [(0, "CIRCLE"), (10, 9), (20, 0), (30, 0), (40, 0.5)]]
    entities += [light(mirrored, d210=0, d220=0, d230=-1), light([*square(5, 0), (5, 0)], closed=0)]
    found = read(tmp_path, text(entities)).assembly
    volume = [block.volume for block in found.blocks]
    assert volume[0] == pytest.approx(np.pi / 14 * (2.5**2 - 2.0**2), rel=2e-3)
    assert volume[1:] == pytest.approx([np.pi / 4, volume[0], 1.0], rel=2e-3)
    assert found.bounds[2] == pytest.approx(found.bounds[0] + [20.0, 0.0, 0.0])
    assert found.bounds[:, :, 1] == pytest.approx(np.tile([-1.0, 0.0], (4, 1)))


def test_arcs_on_each_other_have_the_same_corners(tmp_path: Path) -> None:
    half = float(np.tan(np.pi / 8))
    ring = [(2, 0, half), (0, 2, 0), (0, 3, 0), (3, 0, 0)]
    core = [(2, 0, float(np.tan(np.pi / 12))), (1, 3**0.5, 0), (0, 0, 0)]
    one, other = read(tmp_path, text([light(ring), light(core)])).assembly.blocks
    shared = {tuple(at) for at in one.vertices.round(9)} & {
        tuple(at) for at in other.vertices.round(9)
    }
    assert len(shared) >= 2 * 12


def faces_of(block: drystone.Block, layer: str) -> list[Tags]:
    made = []
    for face in block.faces:
        corners = block.vertices[list(face)]
        corners = np.concatenate([corners, corners[-1:]])[:4]
        made.append(
            [(0, "3DFACE"), (8, layer)]
            + [(10 + 10 * axis + k, at[axis]) for k, at in enumerate(corners) for axis in range(3)]
        )
    return made


def mesh_of(block: drystone.Block, layer: str) -> Tags:
    told = [n for face in block.faces for n in (len(face), *face)]
    points = [(10 * (axis + 1), at[axis]) for at in block.vertices for axis in range(3)]
    return [
        (0, "MESH"),
        (8, layer),
        (92, 8),
        *points,
        (93, len(told)),
        *((90, n) for n in told),
        (94, 1),
        (90, 0),
        (90, 1),
    ]


def polyface_of(block: drystone.Block, layer: str) -> list[Tags]:
    points = [
        [(0, "VERTEX"), (8, layer), (10, x), (20, y), (30, z), (70, 192)]
        for x, y, z in block.vertices
    ]
    faces = [
        [
            (0, "VERTEX"),
            (10, 0),
            (20, 0),
            (30, 0),
            (70, 128),
            *((71 + k, -c - 1) for k, c in enumerate(face)),
        ]
        for face in block.faces
    ]
    return [[(0, "POLYLINE"), (8, layer), (70, 64)], *points, *faces, [(0, "SEQEND")]]


def test_faces_meshes_and_thick_outlines_are_bodies_in_space(tmp_path: Path) -> None:
    from drystone.models import tower

    a, b, c = tower(3).blocks[:3]
    high = light(square(-0.5, -0.5), "top", d38=float(c.vertices[:, 2].max()), d39=0.5)
    entities = [*faces_of(a, "fixed"), mesh_of(b, "mesh"), *polyface_of(c, "old"), high]
    entities.append(light(square(9, 9), "note"))
    found = read(tmp_path, text(entities, units=6))
    assert sorted(found.assembly.names) == ["fixed", "mesh", "old", "top"]
    assert found.assembly.fixed.tolist() == [name == "fixed" for name in found.assembly.names]
    assert "1 outline without a thickness left out beside bodies" in found.notes
    for block, name in ((a, "fixed"), (b, "mesh"), (c, "old")):
        at = found.assembly.names.index(name)
        assert found.assembly.blocks[at].centroid == pytest.approx(block.centroid)
    assert check(drystone.read(tmp_path / "model.dxf")).verdict is Verdict.STABLE
    with pytest.raises(FormatError, match="is no section"):
        read(tmp_path, text(entities), thickness=1.0)


def test_insertions_are_placed_turned_mirrored_and_in_rows(tmp_path: Path) -> None:
    stone = light([(0, 0), (2, 0), (2, 1), (0, 1)])
    blocks: list[Tags] = [
        [(0, "BLOCK"), (2, "Stone"), (10, 1.0), (20, 0), (30, 0)], stone, [(0, "ENDBLK")],
        [(0, "BLOCK"), (2, "pair"), (10, 0), (20, 0), (30, 0)],
        [(0, "INSERT"), (2, "stone"), (10, 0), (20, 0)],
        [(0, "INSERT"), (2, "stone"), (10, 0), (20, 1), (41, -1)], [(0, "ENDBLK")],
    ]  # fmt: skip
    place = [(0, "INSERT"), (8, "wall"), (2, "PAIR"), (10, 10), (20, 0)]
    rows = [(70, 2), (71, 1), (44, 5)]
    turned = [(0, "INSERT"), (2, "stone"), (10, 0), (20, 0), (50, 90)]
    found = read(tmp_path, text([[*place, *rows], turned], blocks=blocks)).assembly
    assert found.names == ("wall-0", "wall-1", "wall-2", "wall-3", "0")
    low = found.bounds[:, 0, [0, 2]]
    assert low == pytest.approx(np.array([[9, 0], [9, 1], [14, 0], [14, 1], [-1, -1]]))


def test_layers_are_chosen_and_hidden_ones_told(tmp_path: Path) -> None:
    tables = [
        [(0, "LAYER"), (2, "off"), (70, 0), (62, -7)],
        [(0, "LAYER"), (2, "on"), (70, 0), (62, 7)],
    ]
    content = text([light(square(0, 0), "on"), light(square(5, 0), "off")], tables=tables)
    found = read(tmp_path, content)
    assert found.assembly.names == ("on",)
    assert "1 hidden object left out on layer 'off'" in found.notes
    assert read(tmp_path, content, layers=["off"]).assembly.names == ("off",)
    assert read(tmp_path, content, hidden=True).assembly.names == ("on", "off")
    with pytest.raises(
        FormatError, match="holds no block on layer 'of'; its layers are 'off', 'on'"
    ):
        read(tmp_path, content, layers=["of"])


LOOP = [[(0, "BLOCK"), (2, "a")], [(0, "INSERT"), (2, "a")], [(0, "ENDBLK")]]
MANY = [
    tag
    for i in range(9)
    for tag in (
        [(0, "BLOCK"), (2, f"b{i}")],
        *[[(0, "INSERT"), (2, f"b{i + 1}")]] * 50,
        [(0, "ENDBLK")],
    )
]
INSERT = [(0, "INSERT"), (2, "a"), (10, 0), (20, 0)]


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (
            text([[(0, "LINE"), (8, "0")]] * 3),
            "holds no closed polyline, face or mesh, but 3 x LINE",
        ),
        (text([light(square(0, 0))]).replace("EOF", "EO"), "ends too early"),
        (text([light(square(0, 0))])[:-40], "ends too early"),
        (text([light([("x", 0), (1, 0), (1, 1)])]), r"line \d+: 'x' is no number"),
        (text([light([("1e999", 0), (1, 0), (1, 1)])]), "is no number"),
        ("solid cube\nfacet\n", "line 1: 'solid cube' is no group code"),
        (text([INSERT], blocks=LOOP), "block 'a' is in itself"),
        (text([[(0, "INSERT"), (2, "b0")]], blocks=MANY), "more than 100,000 entities"),
        (text([[*INSERT, (70, 30000), (71, 30000)]], blocks=LOOP), "more than 100,000 entities"),
        (text([[(0, "MESH"), (93, 3), (90, 4), (90, 0), (90, 1)]]), "or no face"),
        (text([[(0, "MESH"), (93, 4), (90, 3), (90, 0), (90, 1), (90, 2)]]), "does not exist"),
        (
            text([light([(0, 0), (1, 1), (1, 0), (0, 1)])]),
            "no area|zero|flat|touches|crosses|volume",
        ),
        ("AutoCAD Binary DXF\r\n", "save it as a text"),
    ],
)
def test_what_cannot_be_read_is_told_in_one_line(tmp_path: Path, content: str, words: str) -> None:
    with pytest.raises(FormatError, match=words) as caught:
        read(tmp_path, content)
    assert "\n" not in str(caught.value)


def test_an_outline_that_crosses_itself_is_named_by_line_handle_and_layer(tmp_path: Path) -> None:
    bow = light([(0, 1), (1, 2), (1, 1), (0, 2)], "stone")
    bow.insert(1, (5, "2F"))
    content = text([light(square(0, 0), "supports"), bow])
    line = content.splitlines().index("stone") - 4  # after a code, its handle, and its kind
    with pytest.raises(FormatError, match=rf"line {line}, handle 2F.*layer 'stone' crosses"):
        read(tmp_path, content)


def test_a_drawing_whose_layer_holds_everything_says_what_to_do(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    content = text([light(square(0, 0), "supports"), light(square(0, 1), "supports")])
    (tmp_path / "held.dxf").write_text(content, encoding="utf-8")
    assert main(["check", str(tmp_path / "held.dxf")]) == 2
    told = capsys.readouterr().err
    assert "draw what moves on another layer than supports" in told
    assert "--supports" in told


def test_a_thickness_is_a_length_above_zero_of_a_section(tmp_path: Path) -> None:
    content = text([light(square(0, 0))])
    for wrong in (0.0, -1.0, "x", float("nan")):
        with pytest.raises(InputError):
            read(tmp_path, content, thickness=wrong)
    (tmp_path / "a.bricks").write_text("0 0 0 2 4", encoding="utf-8")
    with pytest.raises(FormatError, match="has no thickness to choose"):
        io.read_file(tmp_path / "a.bricks", thickness=1.0)
