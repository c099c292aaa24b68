"""The pictures of the tutorials.

python examples/tutorial_pictures.py docs/images
"""

import sys
from pathlib import Path

import drystone
from drystone.limits import limit_train
from drystone.loads import Fill, Train
from drystone.models import arch, box, bridge, h_model, segmental_bridge, wall
from drystone.sequence import PlanOptions, Robot, Rules
from drystone.settlement import support_response

SIZE = (8.0, 4.4)
"""Inches."""


def main(folder: Path = Path()) -> None:
    """Check, plan and draw what each tutorial asks about."""
    thin = drystone.Model.of(arch(thickness_ratio=0.1, voussoirs=11), friction=0.7)
    span = arch(thickness_ratio=0.15, voussoirs=11)
    cart = drystone.LoadCase.point_load(span, "voussoir-03", (0.0, 0.0, -500.0))  # N
    loaded = drystone.LoadCase.gravity(span) + cart
    ring = drystone.Model.of(segmental_bridge(8.0, 2.0, 0.5, 24), density=2200)
    crossed = limit_train(
        ring, train=Train.named("lm1"), fill=Fill(0.4, 19e3, k=0.3), steps=20, friction=0.6
    )
    earth = "earth:side=-y,weight=18kN/m3,k=active:30deg"
    held = drystone.check(wall(9, 2, (1.0, 1.1, 0.3)), load=[earth], friction=0.6)
    blocks = [box((12.0, 12.0, 1.0), (-3.0, -3.0, -1.0), "ground")]
    for i in range(5):
        blocks.append(box((6.0, 0.6, 1.0), (0.0, 0.0, i), f"facade-{i}"))
        blocks.append(box((0.5, 1.5, 1.0), (0.0, 0.6, i), f"left-{i}"))
        blocks.append(box((0.5, 1.5, 1.0), (5.5, 0.6, i), f"right-{i}"))
    chapel = drystone.Model.of(drystone.Assembly(blocks).with_fixed(["ground"]), friction=0.6)
    spread = drystone.Model.of(arch(0.2, 20, 2.0), friction=0.6)
    robots = Robot("left", (-2, 0, 0), 3.0), Robot("right", (2, 0, 0), 3.0, 150.0)
    team = Rules(hands=2, robots=robots)
    pictures = {
        "architect": drystone.check(thin),
        "bridge": crossed.limit or crossed,
        "church-wall": drystone.seismic.local_mechanism(chapel, direction="-y", part="facade-*"),
        "engineer": drystone.check(span, friction=0.7, load=loaded),
        "retaining-wall": held,
        "roboticist": drystone.plan(
            drystone.Model.of(bridge(), friction=0.5), options=PlanOptions(rules=team)
        ),
        "researcher": drystone.check(h_model(), friction=0.84),
        "vault": support_response(spread, {"springer-right": (0.01, 0.0, 0.0)}),
    }
    for name, subject in pictures.items():
        higher = {
            "bridge": SIZE[0],
            "vault": 5.4,
            "roboticist": 5.2,
        }  # room for arrows and for the text above
        size = (SIZE[0], higher.get(name, SIZE[1]))
        drystone.save_figure(subject, folder / f"tutorial-{name}.png", size=size, dpi=110)


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path())
