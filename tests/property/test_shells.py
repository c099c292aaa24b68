"""Whatever the layout: cells fill the patch, neighbours share whole faces, joints are planar."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from drystone import find_contacts
from drystone.detection import DetectionOptions
from drystone.shells import (
    Edge,
    Layout,
    Shape,
    ShellBody,
    Side,
    barrel_vault,
    build_shell,
    dome,
    patch_from_function,
    shape_volume,
)


def fan(u, v):
    return np.stack([(3.0 + 3.0 * v) * (u - 0.5), 6.0 * v, 4.0 * u * (1.0 - u)], axis=-1)


SHAPES = (
    barrel_vault(6.0, 5.0, 2.0),
    dome(4.0, 1.0),
    Shape(
        (patch_from_function(fan, name="fan"),),
        supports=(Edge(0, Side.BOTTOM), Edge(0, Side.TOP)),
    ),
)
LAYOUTS = st.builds(
    Layout,
    courses=st.integers(6, 9),
    width=st.floats(0.8, 1.6),
    wedge=st.floats(-0.25, 0.25),
    staggered=st.booleans(),
)


@settings(max_examples=6, deadline=None, derandomize=True)
@given(shape=st.sampled_from(SHAPES), layout=LAYOUTS, thickness=st.floats(0.15, 0.35))
def test_blocks_fit(shape, layout, thickness):
    shell = build_shell(shape, layout, ShellBody(thickness=thickness))
    assert shell.planar.reached
    assert {len(users) for users in shell.beside.values()} <= {1, 2}
    assert abs(shell.volume / shape_volume(shape, thickness) - 1.0) < 0.02
    found = find_contacts(shell.assembly, options=DetectionOptions(gap=1e-6))
    assert found.report.overlaps == ()
    pairs = {
        frozenset(pair)
        for pair in zip(
            found.contacts.block_a.tolist(), found.contacts.block_b.tolist(), strict=True
        )
    }
    assert pairs == {frozenset(joint.blocks) for joint in shell.contacts}
