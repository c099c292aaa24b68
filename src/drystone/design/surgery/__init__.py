"""Changes of blocks and joints that keep every block closed."""

from drystone.design.surgery.block_surgery import (
    cut_block,
    faces_toward,
    insert_block,
    merge_blocks,
    move_face,
    thicken_blocks,
)
from drystone.design.surgery.joint_surgery import (
    hook_joint,
    key_joint,
    move_joint,
    still_edge,
    turn_joint,
    wedge_joint,
)

__all__ = [
    "cut_block",
    "faces_toward",
    "hook_joint",
    "insert_block",
    "key_joint",
    "merge_blocks",
    "move_face",
    "move_joint",
    "still_edge",
    "thicken_blocks",
    "turn_joint",
    "wedge_joint",
]
