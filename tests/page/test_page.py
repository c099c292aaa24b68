"""Pages in a real browser: they draw, obey their controls, and ask nothing of the network."""

from __future__ import annotations

import io
import re
import time
import xml.etree.ElementTree as ET
from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

import drystone
from drystone.assembly import Assembly
from drystone.design import Changed
from drystone.detection import find_contacts
from drystone.io import Inspection
from drystone.loads import Earth, LoadCase
from drystone.models import arch, box, bridge, curve_three_blocks, incline, shelf, tower
from drystone.results import Result
from drystone.sequence import PlanOptions, Robot, Rules
from drystone.view import save_page
from tests.page.browser import PATIENCE, Browser, Tab

PICTURES = """
const own = WebGL2RenderingContext.prototype.clear;
window.begun = 0;
WebGL2RenderingContext.prototype.clear = function (...given) {
  window.begun += 1;
  own.apply(this, given);
};"""
EVIL = "</script><img src=x onerror=\"alert('x')\"><b>&amp;"


@pytest.fixture(scope="module")
def standing() -> Result:
    return drystone.check(arch(0.2, 8), friction=0.7)


@pytest.fixture(scope="module")
def shown(
    chromium: Browser, standing: Result, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[Tab]:
    """The page of the arch that stands."""
    path = tmp_path_factory.mktemp("page") / "arch.html"
    save_page(standing, path)
    tab = chromium.open(path)
    chromium.tabs.remove(tab)  # it stays from one test to the next
    yield tab
    chromium.tabs.append(tab)
    tab.close()


@pytest.fixture
def stands(shown: Tab) -> Iterator[Tab]:
    """That page in front, with nothing chosen, for tests that leave it so or do not mind."""
    shown.send("Page.bringToFront")
    shown.key("Escape")
    yield shown
    assert shown.complaints() == []
    assert shown.requests() == []


def pixels(tab: Tab) -> bytes:
    tab.frames(3)
    # where pictures come slowly they are coarse at first
    tab.until(
        "document.getElementById('view').width"
        " === Math.round(document.getElementById('view').clientWidth * devicePixelRatio)"
    )
    return tab.picture("#view")


def becomes(tab: Tab, wanted: Callable[[bytes], bool]) -> bool:
    """Whether the picture is as wanted before patience ends: a busy machine shows it late."""
    end = time.monotonic() + PATIENCE
    while not wanted(pixels(tab)):
        if time.monotonic() > end:
            return False
    return True


def test_the_page_of_a_result_says_the_answer_and_shows_the_forces(opened, standing):
    tab = opened(standing)
    assert tab.text("h1") == "Stands"
    asked = tab.text("#asked")
    for one in ("10 blocks", "free mass ", "density 2400 kg/m³", "friction 0.7", "gravity"):
        assert one in asked
    assert "supports: springer-left, springer-right" in asked
    assert asked.endswith(f"drystone\u00a0{drystone.__version__}")
    # joints are seen as lines, and no unit stands alone on a line
    assert re.search("normal force at a corner, up to [0-9.]+\u00a0k?N", tab.text("#legend"))
    tab.click("#side")
    assert "normal force at a corner" in tab.text("#legend")
    assert "force network (normal forces), up to" in tab.text("#legend")
    assert tab.run("document.querySelector('[data-preset=forces]').ariaPressed") == "true"
    for straight in ("#front", "#side"):  # from the front one looks along all joints
        tab.click(straight)
        for preset, label in (("contacts", "interfaces"), ("utilisation", "friction used")):
            tab.click(f"[data-preset={preset}]")
            assert label in tab.text("#legend")
    tab.click("#front")  # joints lie over the edges of blocks
    picture = Image.open(io.BytesIO(pixels(tab))).convert("RGB").getcolors(1 << 20)
    assert sum(count for count, colour in picture if colour == (0, 114, 178)) > 150


def test_every_preset_and_every_slider_changes_the_picture(opened, standing):
    tab = opened(standing)
    tab.click("#side")
    before = pixels(tab)
    for preset in ("solid", "contacts", "utilisation"):
        tab.click(f"[data-preset={preset}]")
        after = pixels(tab)
        assert after != before
        before = after
    tab.run("document.getElementById('section-axis').value = '0'")
    tab.run("document.getElementById('section-axis').dispatchEvent(new Event('change'))")
    for slider, value in (
        ("#opacity", 0.5),
        ("#spread", 0.6),
        ("#section", -0.3),
        ("#motion", 1),
    ):
        tab.slide(slider, value)
        assert ("friction used" in tab.text("#legend")) == (slider != "#motion")  # as drawn
        after = pixels(tab)
        assert after != before, slider
        before = after


def test_a_fall_plays_once_and_its_slider_moves_the_blocks(opened):
    earth = LoadCase.gravity(shelf()) + Earth("-y", 100.0, 0.5).on(shelf())
    falling = drystone.check(shelf(), friction=0.9, load=earth)
    tab = opened(falling)
    assert tab.text("h1") == "Falls: 2 of 11 blocks"
    assert "force network" not in tab.text("#legend")
    before = pixels(tab)
    tab.slide("#motion", 0.7)
    assert pixels(tab) != before
    assert "pressure on faces" in tab.text("#legend")  # as long as it plays
    tab.click("#play")
    assert tab.text("#play") == "Stop"
    tab.click("#play")
    assert tab.text("#play") == "Play"
    tab = opened(falling, still=False)  # who wants no motion gets none unasked
    tab.until("Number(document.getElementById('motion').value) > 0")
    tab.click("#play")


def test_a_click_on_a_joint_and_on_a_block_opens_its_card(stands):
    stands.run("document.querySelector('#worst button').click()")
    assert stands.text("#card h2").startswith("Joint ")
    assert stands.run("document.querySelectorAll('#card svg .kern').length") == 1
    stands.click("#card .row button")
    assert stands.text("#card h2").startswith("Block ")
    stands.key("Escape")
    assert stands.run("document.querySelector('#card h2')") is None


def test_a_curved_joint_is_one_joint_wherever_it_is_clicked(opened):
    curved = drystone.check(curve_three_blocks(8), friction=0.7)
    assert (curved.contacts.count, curved.contacts.joints.count) == (15, 2)
    tab = opened(curved, size=(1000, 700))
    tab.click("[data-preset=contacts]")
    tab.click("#fit")
    for joint, facets in {
        "Joint 1: cradle – roller": [(300, 300), (340, 320), (380, 350), (350, 365)],
        "Joint 0: base – cradle": [(270, 385), (310, 420), (340, 450), (350, 495)],
    }.items():
        for x, y in facets:
            tab.press(x, y)
            assert tab.text("#card h2") == joint
    for mark in ("outline", "kern", "centre"):
        assert tab.run(f"document.querySelectorAll('#card svg .{mark}').length") == 1
    for table in tab.run(
        "[...document.querySelectorAll('#worst details')].map((one) =>"
        " [...one.querySelectorAll('button')].map((line) => line.textContent))"
    ):
        assert len(table) == len(set(table)) <= 2
    tab.run("URL.createObjectURL = (blob) => { window.made = blob; return 'data:,'; };")
    tab.click("#csv")
    assert len(tab.run("window.made.text()").split("\r\n")) == 2 + 2


def test_hovering_tells_what_lies_under_the_pointer(opened):
    tab = opened(tower(1), size=(1000, 700))
    tab.mouse("mouseMoved", 345, 350)
    tab.until("!document.getElementById('tip').hidden")
    assert tab.text("#tip").startswith("block-0, ")
    tab.press(345, 350)
    assert tab.text("#card h2") == "Block block-0"


def test_part_of_a_name_finds_blocks(stands):
    stands.run(
        "(() => { const e = document.getElementById('name'); e.value = 'SPRINGER';"
        " e.dispatchEvent(new Event('input')); })()"
    )
    assert stands.run("document.querySelectorAll('#matches button').length") == 2
    stands.run("document.getElementById('find').requestSubmit()")
    assert "springer" in stands.text("#card h2")


def test_blocks_are_hidden_and_isolated_and_come_back(stands):
    stands.key("Escape")  # the picture has the focus from here on
    before = pixels(stands)
    stands.key(".")
    selected = stands.text("#card h2")
    stands.key("i")
    assert becomes(stands, lambda picture: picture != before)
    assert stands.text("#card h2") == selected
    assert stands.text("#all").startswith("Show ")
    stands.key("a")
    stands.key("Escape")
    assert stands.run("document.getElementById('all').hidden")
    assert becomes(stands, lambda picture: picture == before)


def test_names_are_written_on_blocks_that_are_seen(opened):
    blocks = (box((4.0, 1.0, 1.0), name="front"), box((0.5, 0.5, 0.5), (0.0, 3.0, 0.0), "behind"))
    tab = opened(drystone.check(drystone.Model.of(Assembly(blocks, fixed=[True, True]))))
    tab.run("document.querySelector('[data-layer=names]').click()")
    tab.run("URL.createObjectURL = (blob) => { window.made = blob; return 'data:,'; };")
    tab.key("1")
    for opacity, seen in ((1, "front"), (0.5, "frontbehind")):
        tab.slide("#opacity", opacity)
        tab.click("#svg")
        root = ET.fromstring(tab.run("window.made.text()"))
        texts = [text.text for text in root.findall(".//{http://www.w3.org/2000/svg}text")]
        assert "".join(text for text in texts if text in ("front", "behind")) == seen


def test_names_that_are_html_stay_text(opened):
    plain = tower(3)
    named = tuple(b.renamed(f"{EVIL}{i}") for i, b in enumerate(plain.blocks))
    tab = opened(drystone.check(Assembly(named, plain.fixed), friction=0.6))
    tab.key(".")
    assert tab.text("#card h2") == f"Block {EVIL}0"
    tab.run("document.querySelector('[data-layer=names]').click()")
    tab.frames()
    assert tab.run("document.querySelectorAll('img[src=x], b').length") == 0


@pytest.mark.parametrize("how", [{"dark": True}, {"forced": True}, {"size": (390, 800)}])
def test_dark_forced_and_small_screens_draw_too(opened, standing, how):
    tab = opened(standing, **how)
    assert tab.run("document.getElementById('trouble').hidden")
    assert len(tab.picture()) > 5_000
    assert tab.run("document.documentElement.scrollWidth <= innerWidth")


def test_a_printed_page_holds_the_picture(stands):
    paper = stands.printed()
    assert b"/Image" in paper
    assert len(re.findall(rb"/Type\s*/Page\b", paper)) == 1  # the legend is not cut off
    stands.until("document.getElementById('printed').hidden")


def test_the_page_of_a_limit_says_the_limit_shows_both_sides_and_prints_its_chart(opened):
    tab = opened(drystone.limit_tilt(tower(2), "y", friction=0.3))
    tab.send("Emulation.setEmulatedMedia", media="print")
    height = "document.querySelector('{}').getBoundingClientRect().height"
    assert tab.run(height.format(".chart svg")) > 100.0
    assert tab.run(height.format("#presets")) == 0.0
    assert len(re.findall(rb"/Type\s*/Page\b", tab.printed())) == 2
    tab.send("Emulation.setEmulatedMedia", media="")
    assert tab.text("h1").startswith("Stands up to 16.")
    assert tab.run("document.querySelectorAll('aside svg use').length") > 0
    before = pixels(tab)
    tab.click("#stage-on")
    assert "about y; falls at 16." in tab.text("h1")
    assert pixels(tab) != before
    assert tab.run("document.querySelector('[data-preset=solid]').ariaPressed") == "true"


COARSE_AT_FIRST = """
const [wait, write, next] = [
  WebGL2RenderingContext.prototype.clientWaitSync, CanvasRenderingContext2D.prototype.fillText,
  window.requestAnimationFrame,
];
let slow = true; // no picture is done, and the first one comes late
window.finish = () => { slow = false; };
window.written = [];
WebGL2RenderingContext.prototype.clientWaitSync = function (...given) {
  return slow ? this.TIMEOUT_EXPIRED : wait.call(this, ...given);
};
CanvasRenderingContext2D.prototype.fillText = function (text, ...given) {
  window.written.push(text);
  write.call(this, text, ...given);
};
window.requestAnimationFrame = (made) => next((now) => {
  for (const begun = performance.now(); performance.now() < begun + 110;);
  window.requestAnimationFrame = next;
  made(now);
});"""


def test_the_page_of_a_plan_brings_each_block_in(opened):
    model = drystone.Model.of(tower(3))
    tab = opened(drystone.plan(model), size=(900, 600), before=COARSE_AT_FIRST)
    assert {"1", "2"} <= set(tab.run("window.written"))
    tab.run("window.finish()")
    assert tab.text("h1") == "Can be assembled without help"
    assert tab.text("#stage-label") == "all blocks, after 2 steps"
    tab.slide("#stage", 0)
    assert tab.text("h1") == "Step 1 of 2: stands without help"
    assert tab.text("#stage-label") == "step 1 of 2: block-1"
    before = pixels(tab)
    tab.slide("#motion", 0.2)
    assert pixels(tab) != before
    tab.key("PageDown")
    assert tab.text("#stage-label").startswith("step 2 of 2")
    assert tab.run("document.getElementById('motion').value") == "1"
    # the outline of where the block comes from is below the words
    tab.click("#fit")
    tab.run("document.getElementById('verdict').style.visibility = 'hidden'")
    tab.run("document.activeElement.blur()")  # no ring around the picture
    pixels(tab)
    behind = Image.open(io.BytesIO(tab.picture("#verdict"))).convert("L")
    assert behind.getextrema()[0] > 200


def test_the_page_of_a_plan_fits_above_the_largest_legend(opened):
    """The view that it opens with is that of *Fit* at the step of which the legend tells most."""
    team = [Robot("left", (-2, 0, 0), 3.0, 120.0), Robot("right", (2, 0, 0), 3.0, 150.0)]
    rules = PlanOptions(rules=Rules(robots=team))
    tab = opened(drystone.plan(bridge(), friction=0.5, options=rules), size=(1000, 620))
    counted, views = [], []
    for step in (9, 4):
        tab.slide("#stage", step)
        if views:
            tab.click("#fit")
        tab.frames(60)
        counted.append(tab.run("document.querySelectorAll('#legend > *').length"))
        tab.click("#link")
        address = tab.run("document.getElementById('address').value")
        views.append([float(x) for x in re.search("v=([^&]*)", address)[1].split("%2C")])
    assert counted[1] > counted[0] + 1
    np.testing.assert_allclose(views[1], views[0], rtol=1e-3, atol=1e-3)


def test_the_page_of_contacts_draws_near_misses(opened):
    blocks = (box((2.0, 2.0, 0.5)), box((1.0, 1.0, 1.0), (0.5, 0.5, 0.51), "cube"))
    model = Assembly(blocks)
    tab = opened(lambda path: save_page(Inspection(model, find_contacts(model)), path))
    assert tab.text("h1") == "2 blocks, 0 interfaces, 1 near miss"
    assert "near misses" in tab.text("#legend")


def test_exports_hold_the_picture_and_the_joints(opened, standing):
    tab = opened(standing)
    tab.run(
        "URL.createObjectURL = (blob) => { window.made = blob; return 'data:,'; };"
        " HTMLAnchorElement.prototype.click = function () { window.named = this.download; };"
    )
    tab.click("#csv")
    rows = tab.run("window.made.text()").split("\r\n")
    assert rows[0].startswith("joint,block_a,block_b,area_m2,friction,normal_N")
    assert len(rows) == standing.contacts.count + 2
    assert rows[1].split(",")[4] == "0.7"  # in the digits of a single number
    assert tab.run("window.named") == "drystone-stands.csv"
    tab.click("#side")
    tab.click("#svg")
    root = ET.fromstring(tab.run("window.made.text()"))
    assert len(root.findall(".//{http://www.w3.org/2000/svg}polygon")) > 20
    told = [text.text for text in root.findall(".//{http://www.w3.org/2000/svg}text")]
    assert "Stands" in told
    assert any(text.startswith("normal force at a corner: 0 N to ") for text in told)
    tab.run("document.getElementById('section-axis').value = '2'")
    tab.run("document.getElementById('section-axis').dispatchEvent(new Event('change'))")
    tab.slide("#section", -0.7)
    tab.click("#svg")
    cut = ET.fromstring(tab.run("window.made.text()"))
    polygons = [len(one.findall(".//{http://www.w3.org/2000/svg}polygon")) for one in (root, cut)]
    assert polygons[1] < polygons[0]
    highest = [
        min(float(p.split(",")[1]) for one in made.iter("{http://www.w3.org/2000/svg}polygon")
            for p in one.get("points").split())
        for made in (root, cut)
    ]  # fmt: skip
    assert highest[1] > highest[0] + 50.0  # the crown of the arch is cut off
    tab.click("#png")
    tab.until("window.made.type === 'image/png'")
    assert tab.run("window.made.size") > 20_000
    tab.click("#link")
    assert "#v=" in tab.run("document.getElementById('address').value")


def test_a_link_brings_the_view_back(opened, standing):
    tab = opened(standing)
    tab.click("#side")
    tab.click("[data-preset=utilisation]")
    tab.run("document.getElementById('section-axis').value = '1'")
    tab.run("document.getElementById('section-axis').dispatchEvent(new Event('change'))")
    tab.slide("#section", 0.25)
    for key in (".", "h", ".", ".", "h"):
        tab.key(key)
    tab.click("#link")
    view = tab.run("document.getElementById('address').value").split("#")[1]
    again = opened(standing, fragment=f"#{view}")
    assert again.run("document.querySelector('[data-preset=utilisation]').ariaPressed") == "true"
    assert again.run("document.getElementById('section-axis').value") == "1"
    assert again.run("document.getElementById('section').value") == "0.25"
    assert again.text("#all") == "Show 2 hidden"
    again.click("#link")
    assert again.run("document.getElementById('address').value").split("#")[1] == view


def test_the_model_fills_the_view(opened):
    tab = opened(tower(2), size=(1000, 700))
    tab.click("#front")
    tab.run("document.querySelector('[data-layer=ground]').click()")
    tab.frames(3)
    ratio = tab.run(
        """(() => {
          const c = document.getElementById('view');
          const flat = document.createElement('canvas');
          flat.width = c.width; flat.height = c.height;
          const pen = flat.getContext('2d');
          return new Promise((done) => requestAnimationFrame(() => {
            window.dispatchEvent(new Event('resize'));
            requestAnimationFrame(() => {
              pen.drawImage(c, 0, 0);
              const d = pen.getImageData(0, 0, c.width, c.height).data;
              let low = c.height, high = 0;
              for (let y = 0; y < c.height; y++) for (let x = 0; x < c.width; x++) {
                const i = 4 * (y * c.width + x);
                if (d[i] + d[i + 1] + d[i + 2] > 700) continue;
                low = Math.min(low, y);
                high = Math.max(high, y);
              }
              done((high - low) / c.height);
            });
          }));
        })()"""
    )
    assert ratio > 0.7


def test_what_falls_and_the_help_that_it_needs_are_inside_the_view(opened):
    tab = opened(drystone.check(arch(0.2, 8), friction=0.2), size=(900, 600), before=PICTURES)
    assert tab.run("begun") == 1  # a page opens with one picture
    tab.run("document.querySelector('[data-layer=ground]').click()")
    tab.frames(3)
    assert tab.run("document.querySelector('[data-layer=help]') !== null")
    drawn = tab.run(
        """new Promise((done) => requestAnimationFrame(() => {
          const c = document.getElementById('view');
          const pen = document.createElement('canvas').getContext('2d');
          [pen.canvas.width, pen.canvas.height] = [c.width, c.height];
          window.dispatchEvent(new Event('resize'));
          requestAnimationFrame(() => {
            pen.drawImage(c, 0, 0);
            const d = pen.getImageData(0, 0, c.width, c.height).data;
            const dark = { left: 0, right: 0, top: 0, all: 0 };
            for (let y = 0, i = 0; y < c.height; y++) for (let x = 0; x < c.width; x++, i += 4) {
              if (d[i] + d[i + 1] + d[i + 2] >= 600) continue;
              dark.all += 1;
              if (x < 2) dark.left += 1;
              if (x >= c.width - 2) dark.right += 1;
              if (y < 2) dark.top += 1;
            }
            done(dark);
          });
        }))"""
    )
    assert (drawn["left"], drawn["right"], drawn["top"]) == (0, 0, 0)
    assert drawn["all"] > 1000


def test_a_settlement_plays_its_states_and_blocks_come_apart(opened):
    tab = opened(drystone.settle(drystone.Model.of(arch(0.2, 4), friction=0.15)))
    before = pixels(tab)
    for slider, value in (("#motion", 0.5), ("#motion", 1), ("#spread", 1)):
        tab.slide(slider, value)
        after = pixels(tab)
        assert after != before, (slider, value)
        before = after


def test_a_picture_of_another_size_shows_the_whole_model_until_it_is_moved(opened, standing):
    """As soon as the window says so: the observer tells it after a frame was drawn."""
    tab = opened(standing, before="window.ResizeObserver = class { observe() {} }")
    for moved in (False, True):
        tab.key("ArrowLeft" if moved else "f")
        tab.send("Emulation.setDeviceMetricsOverride", width=1000 if moved else 560, height=480,
                 deviceScaleFactor=0.5, mobile=False)  # fmt: skip
        seen = pixels(tab)
        tab.key("f")
        assert (seen == pixels(tab)) != moved


def test_a_plane_structure_opens_from_the_front_and_others_do_not(stands, opened):
    for tab, flat in ((stands, True), (opened(tower(2)), False)):
        tab.send("Page.bringToFront")
        tab.click("#link")
        assert ("&f=1" in tab.run("document.getElementById('address').value")) is flat


def test_fit_leaves_out_most_of_a_slab_below_a_column(opened):
    column = [box((1.0, 1.0, 1.0), (-0.5, -0.5, float(z)), f"b{z}") for z in range(3)]
    distance = {}
    for side in (1.0, 40.0):
        slab = box((side, side, 0.2), (-0.5 * side, -0.5 * side, -0.2), "slab")
        assembly = Assembly((slab, *column), (True, False, False, False))
        tab = opened(drystone.check(drystone.Model.of(assembly)))
        tab.click("#link")
        view = tab.run(
            "new URLSearchParams(document.getElementById('address').value.split('#')[1]).get('v')"
        )
        distance[side] = float(view.split(",")[2])
    assert distance[40.0] < 1.5 * distance[1.0]


def test_what_stands_has_no_ghost(stands):
    stands.click("[data-preset=solid]")
    assert "virtual displacement" not in stands.text("#legend")


def test_the_worst_joints_are_drawn_as_plans(stands):
    stands.run("document.querySelector('#worst details').open = true")
    stands.until("document.querySelectorAll('#worst .plans svg .kern').length === 4")
    stands.click("#worst .plans figure")
    assert stands.text("#card h2").startswith("Joint")


def smaller() -> Changed:
    """A tower of two cubes, and the same with the upper one half as high."""
    before = drystone.Model.of(tower(2), friction=0.5)
    low = box((1.0, 1.0, 0.5), (-0.5, -0.5, 1.0), "block-1")
    blocks = (before.assembly.blocks[0], replace(low, density=2400.0))
    after = drystone.Model.of(replace(before.assembly, blocks=blocks), friction=0.5)
    return Changed.by_hand(before, drystone.check(after), "a lower block")


@pytest.mark.parametrize("how", [{"size": (1000, 700)}, {"size": (390, 844), "touch": True}])
@pytest.mark.parametrize("subject", ["plan", "plank", "edges"])
def test_supports_that_are_not_much_larger_and_edges_that_were_are_not_cut(opened, subject, how):
    made = {
        "plan": lambda: drystone.plan(tower(2)),
        "plank": lambda: drystone.check(incline(20.0), friction=0.6),
        "edges": lambda: smaller().layers(),
    }[subject]()
    tab = opened(made, **how)
    tab.run("URL.createObjectURL = (blob) => { window.made = blob; return 'data:,'; };")
    tab.click("#svg")
    places = []
    for one in ET.fromstring(tab.run("window.made.text()")):
        numbers = [float(x) for x in re.split("[ ,]", one.get("points", "")) if x]
        places += zip(numbers[::2], numbers[1::2], strict=True)
        if one.get("x1"):
            places += [(float(one.attrib[f"x{k}"]), float(one.attrib[f"y{k}"])) for k in "12"]
    head = tab.run("document.getElementById('verdict').getBoundingClientRect().bottom")
    wide, high = tab.run("['width', 'height'].map((x) => view.getBoundingClientRect()[x])")
    assert len(places) > 20
    outside = [(x, y) for x, y in places if not (0.0 <= x <= wide and head <= y <= high)]
    assert outside == []


def test_the_legend_has_the_colours_of_the_blocks(opened, standing):
    tab = opened(standing)
    swatch = "getComputedStyle([...document.querySelectorAll('#legend div')]"
    swatch += ".find((one) => one.textContent === 'support').firstChild).backgroundColor"
    for opacity in (None, 0.6):
        if opacity is not None:
            tab.slide("#opacity", opacity)
        picture = np.array(Image.open(io.BytesIO(pixels(tab))).convert("RGB"), dtype=float)
        told = np.array([float(one) for one in re.findall("[0-9]+", tab.run(swatch))[:3]])
        near = np.abs(picture - told).max(axis=2) < 16.0  # shades differ with the light
        assert near.sum() > 300, (opacity, told)


def test_the_model_stands_below_details_that_are_open(opened, standing):
    tab = opened(standing)

    def size(width: int, height: int) -> None:
        tab.send(
            "Emulation.setDeviceMetricsOverride", width=width, height=height,
            deviceScaleFactor=0.5, mobile=False,
        )  # fmt: skip
        tab.click("#fit")
        pixels(tab)

    def colours() -> int:
        """Of the row below the words: more than that of the ground where the model lies there."""
        low = tab.run("document.getElementById('verdict').getBoundingClientRect().bottom")
        picture = Image.open(io.BytesIO(pixels(tab))).convert("RGB")
        row = int(0.5 * low)
        return len(picture.crop((9, row, picture.width - 9, row + 1)).getcolors(1 << 12))

    size(1200, 700)
    tab.click("#details summary")
    assert colours() == 1
