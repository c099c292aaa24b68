"""Tables of parameters: limits and verdicts of each row, kept in a file, and their charts."""

import json
import math
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import pytest

import drystone
from drystone import DrystoneError, InputError
from drystone.answer.chart import MarkKind
from drystone.cli import main
from drystone.limits import Bracket, limit_load, limit_tilt
from drystone.loads import LoadCase
from drystone.models import arch, box, tower
from drystone.report import save_study
from drystone.studies import study, study_chart, study_map, study_told
from drystone.studies.limit_words import measured
from drystone.view import save_chart


def pier(width: float, height: float = 2.0) -> drystone.Assembly:
    base = box((9.0, 9.0, 1.0), (-4.0, -4.0, -1.0), "base")
    return drystone.Assembly((base, box((width, 1.0, height), (0.0, 0.0, 0.0), "pier"))).with_fixed(
        ["base"]
    )


def refusing(width: float) -> drystone.Assembly:
    if width > 0.6:
        raise InputError("is too wide", where="width")
    if width > 0.5:
        raise RuntimeError("of no family")
    if width < 0.1:
        raise KeyboardInterrupt
    return pier(width)


def test_the_limit_of_each_row_is_that_of_its_parameters() -> None:
    """A pier slides at the angle of friction, or overturns at its width by its height."""
    found = study(pier, {"width": [0.5, 1.0], "friction": [0.3, 0.9]}, limit="tilt --axis y")
    assert list(found.columns)[:4] == ["number", "width", "friction", "verdict"]
    rows = zip(found["width"], found["friction"], strict=True)
    expected = [math.degrees(math.atan(min(friction, width / 2.0))) for width, friction in rows]
    assert found["stands"] == pytest.approx(expected, abs=0.1)
    assert (found["falls"] > found["stands"]).all()
    assert set(found["mechanism"]) == {"pier"}


def test_a_tilt_without_an_axis_says_about_which_one_it_is_the_least(tmp_path: Path) -> None:
    """A pier is 1 m deep along y: the narrow one falls about y, and the wide one about x."""
    out, rows = tmp_path / "found.jsonl", {"width": [0.4, 1.6]}
    found = study(pier, rows, limit="tilt", friction=0.9, out=out)
    again = study(pier, rows, limit="tilt", friction=0.9, out=out)
    assert found["turned"].tolist() == again["turned"].tolist() == ["about y", "about x"]
    heads, cells = study_told(found).cells()
    assert cells[1][heads.index("turned")] == "about x"
    assert study_chart(found).up == "stands up to tilt about y or about x"
    shallow = study(pier, rows, limit="tilt --axis x", friction=0.9)
    assert shallow["turned"].tolist() == ["about x", "about x"]


def test_a_limit_of_strength_takes_the_strength_of_all_rows() -> None:
    """A pier presses evenly on its base with its weight."""
    found = study(pier, {"width": [0.5]}, limit="strength --strength 1MPa")
    stress = 9.81 * float(pier(0.5).mass[1]) / 0.5
    assert found["stands"] == pytest.approx([stress / 1e6], abs=1e-3)
    assert found.bounds == {"stands": True, "falls": False}


def test_rows_are_checked_and_what_is_refused_has_its_reason() -> None:
    found = study(refusing, {"width": [0.5, 0.9, 0.6, 0.2]}, seismic=(0.2, 0.0))
    assert found["verdict"].tolist() == ["stable", "refused", "refused", "unstable"]
    assert "is too wide" in found["message"][1]
    assert "its function: RuntimeError: of no family" in found["message"][2]
    assert found["mechanism"].tolist() == ["", "", "", "pier"]
    with pytest.raises(KeyboardInterrupt):
        study(refusing, {"width": [0.05]})
    checked = study(pier, {"width": [0.5]})
    margin = checked["tilt_margin"]
    assert checked["turned"].tolist() == ["about y"]
    assert margin == pytest.approx(math.degrees(math.atan(0.25)), abs=0.01)


def test_a_study_goes_on_where_it_was_ended_and_does_not_depend_on_workers(tmp_path: Path) -> None:
    few, all_of_it = {"width": [0.4, 0.5]}, {"width": [0.4, 0.5, 0.6]}
    path = tmp_path / "found.jsonl"
    first = study(pier, few, limit="tilt", out=path)
    with ThreadPoolExecutor(1) as executor:
        found = study(pier, all_of_it, limit="tilt", out=path, executor=executor)
    assert found["time_s"][:2].tolist() == first["time_s"].tolist()
    assert found.bounds == {"stands": False, "falls": True}
    assert found["stands"].tolist() == study(pier, all_of_it, limit="tilt")["stands"].tolist()
    for other, message in (
        ({"parameters": {"width": [0.3]}, "limit": "tilt"}, "row 0 has other inputs"),
        ({"parameters": few, "limit": "shrink"}, "of other work: limit"),
    ):
        with pytest.raises(DrystoneError, match=message):
            study(pier, out=path, **other)  # type: ignore[arg-type]


def test_rows_of_a_file_whose_content_was_changed_are_not_kept(tmp_path: Path) -> None:
    model, out = tmp_path / "pier.json", tmp_path / "found.jsonl"
    asked = {"parameters": {"friction": [0.6]}, "limit": "tilt --axis y", "out": out}
    drystone.write(pier(0.2), model)
    study(model, **asked)  # type: ignore[arg-type]
    drystone.write(pier(0.5), model)
    with pytest.raises(DrystoneError, match="is of other work: content differ"):
        study(model, **asked)  # type: ignore[arg-type]
    with pytest.raises(DrystoneError, match="is of other work"):
        study(pier(0.5), **asked)  # type: ignore[arg-type]


def test_rows_are_not_kept_where_what_a_family_reads_or_does_has_changed(tmp_path: Path) -> None:
    section, out = tmp_path / "section.toml", tmp_path / "found.jsonl"
    section.write_text("width = 1", "utf-8")
    rows = {"section": [str(section)], "width": [0.3]}
    once = lambda section, width: pier(width)  # noqa: E731
    twice = lambda section, width: pier(2.0 * width)  # noqa: E731
    study(once, rows, out=out)
    with pytest.raises(DrystoneError, match="other work: content differ; name another file"):
        study(twice, rows, out=out)
    section.write_text("width = 2", "utf-8")
    with pytest.raises(DrystoneError, match="other work: inputs differ; name another file"):
        study(once, rows, out=out)


def test_a_data_frame_is_a_table_of_parameters_and_a_model_has_options_of_reading() -> None:
    pandas = pytest.importorskip("pandas")
    frame = pandas.DataFrame({"friction": [0.3, 0.9]})
    found = study(pier(1.0), frame, limit="tilt --axis y")
    assert found.to_pandas()["stands"].round(0).tolist() == [17.0, 27.0]


@pytest.mark.parametrize(
    ("build", "asked", "message"),
    [
        (pier, {"parameters": {}}, "there is no row"),
        (pier, {"parameters": [{"width": 1.0}, {"height": 1.0}]}, "row 1 has other parameters"),
        (pier, {"parameters": {"verdict": [1.0]}}, "is a column of the answer"),
        (tower(2), {"parameters": {"width": [1.0]}}, "is no option of reading"),
        (pier, {"parameters": {"widht": [1.0]}}, "pier missing a required argument: 'width'"),
        (arch, {"parameters": {"hight": [1.0]}}, "arch got an unexpected .* 'hight'"),
    ],
)
def test_what_is_no_study_is_refused(build: object, asked: dict[str, object], message: str) -> None:
    with pytest.raises(InputError, match=message):
        study(build, **asked)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("limit", "message"),
    [
        ("foo", "there is no limit 'foo'"),
        ("thickness", "give its values by --set"),
        ("tilt --side y", "side"),
        ("load", "live is missing"),
    ],
)
def test_a_limit_that_has_no_column_is_refused_before_the_work(
    limit: str, message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "found.jsonl"
    with pytest.raises(InputError, match=message):
        study(pier, {"width": [0.5]}, limit=limit, out=out)
    assert not out.exists()
    assert main(["study", "tower", "--limit", limit]) == 2
    assert message in capsys.readouterr().err


def test_one_and_two_parameters_are_drawn_as_curves(tmp_path: Path) -> None:
    found = study(pier, {"width": [0.5, 0.4], "friction": [0.3, 0.9]}, limit="tilt --axis y")
    chart = study_chart(found)
    lines = [one for one in chart.marks if one.label]
    assert [one.label for one in lines] == ["friction 0.3", "friction 0.9"]
    assert lines[0].x.tolist() == [0.4, 0.5]
    assert chart.units == ("", "deg")
    save_chart(chart, tmp_path / "study.svg")
    assert (tmp_path / "study.svg").exists()
    one = study_chart(found.take([0, 2]), across="width", by="friction", up="falls")
    assert [mark.label for mark in one.marks] == ["friction 0.3", ""]
    with pytest.raises(InputError, match="has no numbers"):
        study_chart(found, up="message")


LIMITED = {
    "thrust springer-right": ("least", "most"),
    "sweep --directions 4": ("stands", "falls", "towards"),
    "imperfections --offset 0.01 --draws 2": ("share", "least", "most"),
    "train --steps 3": ("factor", "place", "stands", "falls"),
    "decay": ("share", "moved"),
}


@pytest.mark.parametrize("limit", LIMITED)
def test_every_limit_of_the_command_has_columns_of_its_own(limit: str, tmp_path: Path) -> None:
    """Of an arch of three blocks; what is kept in a file gives the same table."""
    asked = {"thickness_ratio": [0.3], "voussoirs": [3]}
    found = study(arch, asked, limit=limit, out=tmp_path / "found.jsonl", friction=0.9)
    columns = list(found.columns)
    assert (
        tuple(columns[columns.index("verdict") + 1 : columns.index("mechanism")])
        == (LIMITED[limit])
    )
    assert found["verdict"].tolist() == ["found"]
    assert math.isfinite(found[LIMITED[limit][0]][0])
    again = study(arch, asked, limit=limit, out=tmp_path / "found.jsonl", friction=0.9)
    assert [*map(str, again)] == [*map(str, found)]


def test_a_thrust_where_no_forces_balance_is_told_apart_from_one_that_is_found() -> None:
    found = study(
        arch, {"thickness_ratio": [0.05, 0.3], "voussoirs": [9]}, limit="thrust springer-right"
    )
    assert found["verdict"].tolist() == ["unbalanced", "found"]
    assert "message" in found.hidden


def test_a_robust_limit_is_that_of_every_stiffness() -> None:
    found = limit_tilt(drystone.Model.of(pier(0.5), friction=0.3), "y")
    low, high = found.best.stands, found.best.falls
    robust = replace(found, robust=Bracket(3.0, 4.0))
    assert robust.sensitive_between is not None
    unsure = [*sorted(robust.sensitive_between), None, None]
    assert measured(robust)[0] == [3.0, 4.0, "about y", *unsure]
    assert measured(found)[0] == [low, high, "about y", *4 * [None]]
    assert found.best.falling is not None
    assert found.best.falling.asked.options == {}  # its numerics are no question


def test_axes_have_words_and_units_and_what_is_fixed_is_said(tmp_path: Path) -> None:
    asked = {"radius": [1.0, 2.0], "thickness_ratio": [0.2], "voussoirs": [11]}
    found = study(arch, asked, limit="friction")
    chart = study_chart(found)
    assert (chart.across, chart.up) == ("radius", "stands down to friction")
    assert chart.units == ("m", "")
    beyond = (found["stands"] - found["falls"]).max()
    assert 0.0 < beyond <= 1e-3  # the width of a limit of friction
    gap = f"it stands at each point, and falls at most {beyond:.2g} beyond"
    assert chart.caption == f"thickness ratio 0.2, voussoirs 11; {gap}"
    assert study_chart(found, up="falls").up == "falls at friction"
    found.to_csv(tmp_path / "found.csv")
    cells = (tmp_path / "found.csv").read_text("utf-8").splitlines()[1].split(",")
    assert max(map(len, cells[5:7])) <= len("0.123456789012")
    both = study(arch, {**asked, "depth": [0.2, 0.3]}, limit="load seismic:1,0", friction=0.7)
    drawn = study_map(both)
    assert (drawn.across, drawn.up) == ("radius [m]", "depth [m]")
    assert drawn.quantity == "stands up to load factor"
    assert drawn.title.endswith("; thickness ratio 0.2, voussoirs 11")


def test_both_sides_of_a_limit_are_told_as_by_its_title() -> None:
    """With more digits than four where four do not tell them apart; a map has the same."""
    asked = {"thickness_ratio": [0.15], "voussoirs": [11], "friction": [0.7], "radius": [1, 2]}
    found = study(arch, asked, limit="load seismic:1,0")
    heads, rows = study_told(found).cells()
    assert f"{found['stands'][0]:.4g}" == f"{found['falls'][0]:.4g}"
    limit = limit_load(arch(0.15, 11), LoadCase.seismic(arch(0.15, 11), 1.0), friction=0.7)
    told = rows[0][heads.index("stands")], rows[0][heads.index("falls")]
    assert limit.title == f"Stands up to load factor {told[0]} g"  # 1 g is a unit
    assert limit.tables()[0].cells()[1][0][1:] == list(told)
    assert study_map(found, "radius", "voussoirs").values[0, 0] == float(told[0])
    tilts = study(arch, {"thickness_ratio": [0.05, 0.2], "voussoirs": [11]}, limit="tilt")
    assert study_told(tilts).cells()[1][0][2] == "-"
    assert tilts["turned"][0] is None


def test_a_row_that_is_stopped_is_not_kept(tmp_path: Path) -> None:
    calls: list[int] = []

    def stop() -> bool:
        calls.append(1)
        return len(calls) > 2  # inside of the first row

    out, rows = tmp_path / "rows.jsonl", {"width": [0.5, 0.4]}
    assert not len(study(pier, rows, limit="tilt --axis y", stop=stop, out=out))
    again = study(pier, rows, limit="tilt --axis y", out=out)
    assert again["verdict"].tolist() == ["found", "found"]


def test_two_parameters_are_drawn_as_a_map_and_written_as_a_page(tmp_path: Path) -> None:
    rows = {"width": [0.5, 0.4], "friction": [0.3, 0.9]}
    found = study(pier, rows, limit="tilt --axis y")
    drawn = study_map(found)
    assert (drawn.columns, drawn.rows) == (("0.4", "0.5"), ("0.3", "0.9"))
    assert drawn.quantity == "stands up to tilt about y [deg]"
    slides, wide, narrow = (math.degrees(math.atan(one)) for one in (0.3, 0.25, 0.2))
    expected = [min(slides, narrow), min(slides, wide), narrow, wide]
    assert drawn.values.ravel() == pytest.approx(expected, abs=0.1)
    save_chart(drawn, tmp_path / "map.svg")
    save_study(found, tmp_path / "study.html")
    text = (tmp_path / "study.html").read_text("utf-8")
    assert text.count("<img") == 2
    assert "Study: tilt --axis y" in text
    with pytest.raises(InputError, match="a map is of two parameters"):
        study_map(study(pier, {"width": [0.5]}, limit="tilt --axis y"))
    with pytest.raises(InputError, match=r"several rows have width 0\.5"):
        study_map(study(pier, [{"width": 0.5, "friction": 0.3}] * 2))


def test_the_command_studies_a_family_and_writes_table_and_chart(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rows = ["count=2", "edge=1:2:2", "friction=0.3", "friction=2"]
    told = ["study", "tower", *(word for row in rows for word in ("--set", row))]
    files = ["--csv", str(tmp_path / "study.csv"), "--out", str(tmp_path / "study.jsonl")]
    files += ["--map", str(tmp_path / "map.png"), "--html", str(tmp_path / "study.html")]
    assert main([*told, "--limit", "tilt", *files]) == 0
    assert "4 rows, 0 refused" in capsys.readouterr().out
    lines = (tmp_path / "study.csv").read_text("utf-8").splitlines()
    assert lines[0].startswith("number,count,edge [m],friction,verdict,stands [deg],falls [deg]")
    assert len(lines) == 5
    assert (tmp_path / "study.html").exists()
    assert main(["study", "tower", "--set", "edge=1:2.4:8", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)["verdicts"]
    assert [row["edge"] for row in told] == [1, 1.2, 1.4, 1.6, 1.8, 2, 2.2, 2.4]
    tied = ["tie=block-0:block-1:20kN", "tie=block-0:block-1:30kN"]
    asked = [word for row in tied for word in ("--set", row)]
    assert main(["study", "tower", *asked, "--json"]) == 0
    told = json.loads(capsys.readouterr().out)["verdicts"]
    assert [f"tie={row['tie']}" for row in told] == tied
    assert main(["study", "tower", "--set", "edge=1:2"]) == 2
    out = ["--out", str(tmp_path / "one.jsonl"), "--map", str(tmp_path / "one.png")]
    assert main(["study", "tower", "--set", "count=2:3:2", *out]) == 2
    assert "--map: draws 2 varying parameters, not 1" in capsys.readouterr().err
    out[2:] = ["--png", str(tmp_path / "one.png")]
    assert main(["study", "wedge", "--set", "kind=c", "--set", "kind=d", *out]) == 2
    assert "--png: 'kind' has no numbers to draw along" in capsys.readouterr().err
    assert not (tmp_path / "one.jsonl").exists()  # refused before the work
    assert main(["study", "tower", "--set", "count=2:3:2", "--set", "friction=0.5"]) == 0
    told = capsys.readouterr()
    assert "2 rows, 0 refused, friction 0.5  tower\n" in told.out
    assert "degrees" not in told.err
    assert main(["study", "tower", "--set", "count=2", "--set", "friction=35"]) == 0
    assert "are degrees meant? Write --set friction=35deg" in capsys.readouterr().err
    assert main(["study", "tower"]) == 2
    assert "--set: is missing" in capsys.readouterr().err


def test_rows_that_fall_are_crosses_and_no_curve_hides_another() -> None:
    rows = {"width": [0.3, 0.4, 0.5], "friction": [0.8, 0.9, 1.0]}
    limits = study(pier, rows, limit="tilt --axis y")
    lines = [one.kind for one in study_chart(limits).marks if one.label]
    assert lines == [MarkKind.LINE, MarkKind.DASHED, MarkKind.LINE]
    thickness = {"thickness_ratio": [0.05, 0.2], "voussoirs": [11]}
    for limit in ("tilt --axis y", ""):
        found = study(arch, thickness, limit=limit, friction=0.7)
        assert math.isnan(found["stands" if limit else "tilt_margin"][0])
        cross = study_chart(found).marks[-1]
        assert (cross.kind, cross.label) == (MarkKind.CROSS, "falls from the start")
        assert (cross.x.tolist(), cross.y.tolist()) == ([0.05], [0.0])


def test_people_read_what_differs_and_programs_read_all(tmp_path: Path) -> None:
    found = study(arch, {"thickness_ratio": [0.05, 0.2], "voussoirs": [11]}, friction=0.7)
    heads = ["thickness ratio", "verdict", "tilt margin [deg]", "turned", "mechanism"]
    assert found.cells()[0] == heads
    assert found.take([0]).cells()[0] == heads
    found.to_csv(tmp_path / "found.csv")
    head, falls, _ = (tmp_path / "found.csv").read_text("utf-8").splitlines()
    assert head.startswith("number,thickness_ratio,voussoirs,verdict,tilt_margin [deg],turned,mech")
    assert falls.startswith("0,0.05,11,unstable,,,")
    refused = study(arch, {"thickness_ratio": [-1.0, 0.2]}, friction=0.7)
    assert "message" in refused.cells()[0]
