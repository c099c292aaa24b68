from __future__ import annotations

import json
import re
import struct
import subprocess
import sys
import time
import xml.etree.ElementTree as ET
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.collections import LineCollection
from matplotlib.lines import Line2D
from scipy.spatial.transform import Rotation

import drystone
from drystone.answer import Scene
from drystone.answer.question import asked_line
from drystone.assembly import Assembly
from drystone.base.errors import InputError
from drystone.base.units import quantity
from drystone.models import arch, box, tower, wall
from drystone.view import page_text, save_chart, save_figure, scene_of
from drystone.view.exploded import taken_apart
from drystone.view.figure import draw
from drystone.view.palette import first_preset
from tests.unit.view.pictures import falling_tower, notched, pulled_tower

SVG = "{http://www.w3.org/2000/svg}"


def png_size(path: Path) -> tuple[int, int]:
    data = path.read_bytes()
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    width, height = struct.unpack(">II", data[16:24])
    return width, height


def test_a_png_has_the_size_that_was_asked_for(tmp_path: Path) -> None:
    path = tmp_path / "tower.png"
    save_figure(falling_tower(), path, size=(4.0, 3.0), dpi=50)
    assert png_size(path) == (200, 150)
    assert list(tmp_path.iterdir()) == [path]
    save_figure(drystone.check(tower(2), friction=0.6), path, size=(1.0, 2.0), dpi=50)
    assert png_size(path) == (50, 100)


def test_an_svg_is_drawn_and_parsed_back(tmp_path: Path) -> None:
    path = tmp_path / "tower.SVG"
    save_figure(falling_tower(("foot", "$x^", "</svg> \u5854")), path)
    root = ET.parse(path).getroot()
    assert root.tag == f"{SVG}svg"
    assert len(root.findall(f".//{SVG}path")) > 9


def test_the_head_of_a_figure_is_whole_above_the_drawing_and_says_nothing_twice() -> None:
    scene = scene_of(drystone.check(tower(2), friction=0.6))
    scene = replace(scene, facts={**scene.facts, "Supports": ", ".join(["pier"] * 60)})
    figure = draw(scene, (6.0, 4.5))
    words = [one.get_text() for one in figure.texts]
    assert [one for one in words if "stands" in one.casefold()] == ["Stands"]
    (head,) = [one for one in figure.texts if "friction" in one.get_text()]
    assert " ".join(head.get_text().split()) == asked_line(scene.facts, scene.made)
    assert head.get_window_extent().y0 > figure.axes[0].get_window_extent().y1


def test_a_long_headline_is_smaller_and_keeps_its_end() -> None:
    scene = scene_of(drystone.check(tower(2), friction=0.6))
    long = "A mechanism begins at 0.12 g: verification linear not fulfilled"
    stages = tuple(replace(one, headline=long) for one in scene.stages)
    (head,) = [one for one in draw(replace(scene, stages=stages), (6.0, 4.5)).texts
               if one.get_text() == long]  # fmt: skip
    assert head.get_fontsize() < 13.0
    stages = tuple(replace(one, headline="Dome wall " * 12) for one in scene.stages)
    figure = draw(replace(scene, stages=stages), (9.0, 6.5))
    (head,) = [one for one in figure.texts if one.get_text().startswith("Dome wall")]
    assert head.get_window_extent().x1 < 0.75 * figure.bbox.width  # the colour bar is beside it
    assert head.get_text().split() == ["Dome", "wall"] * 12


def test_the_scale_bar_stands_below_the_blocks() -> None:
    scene = scene_of(drystone.check(tower(2), friction=0.6))
    figure = draw(scene, (6.0, 4.5))
    figure.canvas.draw()
    (axes,) = [one for one in figure.axes if one.texts]
    (label,) = [one for one in axes.texts if one.get_text().endswith("m")]
    assert label.get_window_extent().y1 < axes.transData.transform(axes.dataLim.min)[1]


@pytest.mark.parametrize("suffix", ["svg", "pdf", "png"])
def test_the_same_answer_is_drawn_to_the_same_bytes(
    suffix: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    answer = drystone.check(tower(2), friction=0.6)
    paths = [tmp_path / f"{i}.{suffix}" for i in range(2)]
    drystone.save_figure(answer, paths[0])
    monkeypatch.setattr(time, "time", lambda: answer.made + 1e6)
    monkeypatch.setattr("drystone.answer.scene.now", lambda: "later")
    drystone.save_figure(answer, paths[1])
    assert paths[0].read_bytes() == paths[1].read_bytes()


def test_pyplot_and_its_state_are_left_alone(tmp_path: Path) -> None:
    code = (
        "import sys; from drystone.models import tower; from drystone.view import save_figure; "
        "save_figure(tower(2), sys.argv[1], size=(2, 2), dpi=40); "
        "sys.exit('matplotlib.pyplot' in sys.modules)"
    )
    arguments = [sys.executable, "-c", code, str(tmp_path / "tower.png")]
    assert subprocess.run(arguments, check=False).returncode == 0


def figure_of(subject: object, **changes: object) -> Any:
    scene = scene_of(subject)  # type: ignore[arg-type]
    return draw(scene, (9.0, 6.5), **changes)  # type: ignore[arg-type]


def texts(figure: Any) -> str:
    legend = figure.legends[0]
    every = [*figure.texts, *figure.axes[0].texts, *legend.get_texts()]
    return "\n".join(text.get_text() for text in every)


def test_joints_that_one_looks_along_are_drawn_as_lines() -> None:
    result = drystone.check(arch(0.2, 6), friction=0.7)
    assert "friction used, along joints, up to 49 %" in texts(
        figure_of(result, preset="utilisation")
    )
    stones = drystone.check(wall(2, 2), friction=0.7)
    told = texts(figure_of(stones, layers=["joint-force"], toward=np.array([1.0, 0.0, 0.0])))
    assert "normal force at a corner, along joints, up to" in told
    forces = figure_of(result, layers=["joint-force"])
    (lines,) = [one for one in forces.axes[0].collections if isinstance(one, LineCollection)]
    widths = np.reshape(lines.get_linewidths(), (-1, 4 * result.contacts.count))
    assert len(lines.get_segments()) == widths.size
    assert np.ptp(widths, axis=0).max() > 1.0  # a joint is pressed more at one end


def test_the_legend_shows_loads_and_reactions_as_arrows() -> None:
    model = drystone.Model.of(arch(0.2, 7), friction=0.7)
    load = drystone.LoadCase.point_load(model.assembly, "voussoir-03", (0.0, 0.0, -500.0))
    layers = ["loads", "reactions", "network"]
    figure = figure_of(drystone.check(model.with_load(model.load + load)), layers=layers)
    legend = figure.legends[0]
    words = [one.get_text().split(",")[0] for one in legend.get_texts()]
    lines = {
        w: h for w, h in zip(words, legend.legend_handles, strict=True) if isinstance(h, Line2D)
    }
    heads = [word for word, line in lines.items() if line.get_marker() != "None"]
    assert heads == ["loads", "reactions at joints of supports"]
    assert "force network (normal forces)" in lines


def test_the_legend_shows_blocks_as_clear_as_they_are_drawn() -> None:
    result = drystone.check(arch(0.2, 7), friction=0.7)
    for preset, clear in (("forces", True), ("solid", False)):
        handles = figure_of(result, preset=preset).legends[0].legend_handles
        support = next(one for one in handles if one.get_label() == "support")
        assert (support.get_facecolor()[3] < 1.0) == clear


def test_the_figure_says_verdict_units_and_scale() -> None:
    text = texts(figure_of(falling_tower()))
    assert "Falls: block 'top'" in text
    assert "The top falls." in text
    for part in ("support", "falls", "first motion", " m"):
        assert part in text
    assert "force" not in text  # what falls is in no equilibrium
    text = texts(figure_of(pulled_tower()))
    assert "force network (normal forces), up to 12 kN" in text
    assert "tension needed at a corner, up to 500 N" in text
    text = texts(figure_of(pulled_tower(), layers=["pressure"]))
    assert "corner forces, up to 3.03 kN" in text


def test_the_colour_bar_says_the_largest_force_and_its_unit() -> None:
    bar = figure_of(pulled_tower()).axes[1]
    assert [tick.get_text() for tick in bar.get_xticklabels()] == ["0 N", "3 kN"]
    assert bar.get_title() == "normal force at a corner"


def test_only_layers_that_were_asked_for_are_drawn() -> None:
    text = texts(figure_of(falling_tower(), layers=["interfaces"]))
    assert "interfaces" in text
    assert "kN" not in text
    with pytest.raises(
        InputError, match=r"interfaces, joint-force, .*, pressure, reactions, resultants"
    ):
        figure_of(pulled_tower(), layers=["presure"])
    with pytest.raises(InputError, match="forces, solid, contacts, utilisation, stages"):
        figure_of(pulled_tower(), preset="force")


def test_the_scale_bar_is_as_long_as_it_says() -> None:
    figure = figure_of(notched())
    axes = figure.axes[0]
    axes.apply_aspect()
    bar = next(line for line in axes.lines if line.get_linewidth() == 2.0)
    across = np.ptp(axes.get_xlim()) * np.ptp(bar.get_xdata())
    told = next(one.get_text() for one in axes.texts if one.get_text().endswith(" m"))
    said = float(told.removesuffix(" m"))
    assert across == pytest.approx(said, rel=0.02)


def test_a_message_with_mathematical_signs_is_plain_text(tmp_path: Path) -> None:
    result = falling_tower()
    object.__setattr__(result, "message", "costs 3 $ and \\frac{$")
    save_figure(result, tmp_path / "a.svg")
    assert (tmp_path / "a.svg").exists()


@pytest.mark.parametrize("toward", [(0, 0, 1), (0, 0, -1), (0, -1, 0), (1, 0, 0)])
def test_straight_views_are_drawn_too(toward: tuple[int, int, int], tmp_path: Path) -> None:
    save_figure(notched(), tmp_path / "a.png", toward=toward, size=(2, 2), dpi=40)
    assert png_size(tmp_path / "a.png") == (80, 80)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"path": "a.gif"}, r"\.png, \.svg or \.pdf"),
        ({"path": "a"}, r"\.png, \.svg or \.pdf"),
        ({"toward": (0, 0, 0)}, "view direction is zero"),
        ({"size": (0, 3)}, "above zero"),
        ({"stage": 4}, "no stage 4"),
    ],
)
def test_bad_wishes_are_refused(changes: dict[str, object], message: str, tmp_path: Path) -> None:
    path = tmp_path / str(changes.pop("path", "a.png"))
    with pytest.raises(InputError, match=message):
        save_figure(tower(2), path, **changes)  # type: ignore[arg-type]
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("value", "text"),
    [(0.0, "0 N"), (12345.0, "12.3 kN"), (999.9, "1 kN"), (0.5, "500 mN"), (2.5e-6, "2.5 µN")],
)
def test_quantities_have_three_digits_and_a_prefix(value: float, text: str) -> None:
    assert quantity(value, "N") == text


def test_a_page_has_the_prefixes_of_a_figure() -> None:
    text = page_text(scene_of(tower(2)))
    told = re.search(r"PREFIXES ?= ?(\[\[.*?\]\])", text)
    assert told is not None
    for factor, prefix in json.loads(told[1]):
        assert quantity(2.0 * factor, "N") == f"2 {prefix}N"
    assert quantity(1e-3 * factor, "N") == f"{1e-3 * factor:g} N"  # neither has a smaller one


def test_a_figure_of_a_plan_numbers_blocks_and_names_are_written_when_asked_for():
    plan = drystone.plan(drystone.Model.of(tower(3)))
    numbered = [text.get_text() for text in save_figure(plan).axes[0].texts]
    assert {"1", "2"} <= set(numbered)
    named = [text.get_text() for text in save_figure(tower(3), names=True).axes[0].texts]
    assert {"block-0", "block-1", "block-2"} <= set(named)
    above = save_figure(tower(3), names=True, toward=(0, 0, 1))
    one_place = [text.get_text() for text in above.axes[0].texts]
    assert "block-2" in one_place  # the nearest of labels that would touch
    assert "block-0" not in one_place


def test_a_label_is_written_on_what_is_seen_of_its_block_only():
    front, back = box((2.0, 1.0, 2.0), name="front"), box((1.0, 1.0, 1.0), (0.5, 2.0, 0.5), "back")
    pair = Assembly((front, back, box((1.0, 1.0, 4.0), (0.5, 5.0, 0.0), "high")))
    texts = save_figure(pair, names=True, toward=(0, -1, 0), preset="stages").axes[0].texts
    at = {text.get_text(): text.get_position()[1] for text in texts}
    assert "back" not in at
    assert at["high"] > at["front"] + 1.2  # above the front, on what is seen of it


def test_a_figure_takes_blocks_apart_with_their_joints():
    result = drystone.check(tower(3), friction=0.6)
    scene = scene_of(result)
    apart = taken_apart(scene, 1.0)
    rise = apart.assembly.centroid - scene.assembly.centroid
    np.testing.assert_allclose(rise, [[0, 0, 0], [0, 0, 1.5], [0, 0, 2.5]], atol=1e-9)
    (before,) = [x for x in scene.stages[0].layers if x.key == "joint-force"]
    (after,) = [x for x in apart.stages[0].layers if x.key == "joint-force"]
    np.testing.assert_allclose(
        (after.position - before.position)[:, 2], np.repeat([0.75, 2.0], 4), atol=1e-9
    )
    drawn, whole = save_figure(result, explode=1.0).axes[0], save_figure(result).axes[0]
    assert np.ptp(drawn.dataLim.intervaly) > 1.4 * np.ptp(whole.dataLim.intervaly)
    with pytest.raises(InputError, match="explode is -1"):
        save_figure(result, explode=-1.0)


def test_the_figure_of_a_limit_shows_the_falling_state_as_solid():
    limit = drystone.limit_tilt(tower(2), "y", friction=0.3)
    scene = scene_of(limit)
    assert (first_preset(scene), first_preset(scene, -1)) == ("forces", "solid")


def test_a_figure_is_drawn_in_axes_beside_others() -> None:
    from matplotlib.figure import Figure

    mine = Figure()
    left, right = mine.subplots(1, 2)
    result = drystone.check(tower(3), friction=0.6)
    assert drystone.save_figure(result, ax=left) is mine
    assert left.get_title() == "Stands"
    assert left.collections
    assert not right.collections
    sweep = drystone.limits.tilt_sweep(drystone.Model.of(tower(2)), 2)
    with pytest.raises(InputError, match="needs polar axes, and ax is rectilinear"):
        drystone.save_figure(sweep, ax=right)
    polar = Figure().add_subplot(projection="polar")
    for drawn in (drystone.save_figure, lambda one, ax: save_chart(one.figure(), ax=ax)):
        polar.clear()
        assert drawn(sweep, ax=polar) is polar.figure
        assert polar.lines
        assert polar.get_title()


def test_a_picture_shows_the_ground_as_a_plate_and_tells_the_size_of_what_stands_on_it() -> None:
    model = drystone.Model.of(tower(3).with_fixed(()), supports="ground", friction=0.6)
    scene = scene_of(model)
    plate, ground = scene.assembly.blocks[-1], model.assembly.blocks[-1]
    low, high = model.assembly.bounds[:-1, 0].min(axis=0), model.assembly.bounds[:-1, 1].max(axis=0)
    assert plate.bounds[1, 2] == ground.bounds[1, 2] == low[2]
    assert (scene.bounds[1] - scene.bounds[0] < 1.3 * (high - low)).all()
    assert scene_of(model).facts["Size"] == "1 x 1 x 3 m"


def test_a_picture_turns_the_ground_as_the_analysis_does() -> None:
    model = drystone.Model.of(tower(1).with_fixed(()), supports="ground", friction=0.6)
    scene = scene_of(model)
    motion = np.zeros((2, 6))
    motion[1] = 0.1, 0.0, 0.0, 0.0, 0.2, 0.0
    bent = replace(scene.stages[0], motion=motion)
    shown = Scene(model.assembly, model.contacts, (bent,))
    turn = Rotation.from_rotvec(motion[1, 3:])
    corner = shown.assembly.blocks[1].vertices
    ends = [
        at.centroid[1] + one.motion[1, :3] + turn.apply(corner - at.centroid[1])
        for at, one in ((model.assembly, bent), (shown.assembly, shown.stages[0]))
        if one.motion is not None
    ]
    np.testing.assert_allclose(ends[1], ends[0], atol=1e-12)


@pytest.mark.parametrize("size", [(3.0, 2.0), (4.0, 3.0), (9.0, 6.5)])
def test_header_drawing_and_legend_do_not_overlap(size: tuple[float, float]) -> None:
    result = drystone.check(arch(0.15, 11), friction=0.7)
    figure = drystone.save_figure(result, size=size, dpi=100)
    drawing = figure.axes[0].get_window_extent()
    assert drawing.height > 0.39 * figure.bbox.height
    assert all(text.get_window_extent().y0 > drawing.y1 for text in figure.texts[1:])
    assert all(legend.get_window_extent().y1 < drawing.y0 for legend in figure.legends)


def test_a_picture_of_stones_alone_has_the_headline_and_no_facts() -> None:
    result = drystone.check(arch(0.15, 11), friction=0.7)
    plain = drystone.save_figure(result, preset="solid")
    told = " ".join(text.get_text() for text in plain.texts)
    assert "Stands" in told
    assert "kg" not in told
