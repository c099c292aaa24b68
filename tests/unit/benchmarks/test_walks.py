"""The walk from a check to the elimination is followed."""

from benchmarks.walks import ELIMINATION, followed
from drystone import Model, check
from drystone.models import arch


def test_the_walk_from_a_check_ends_in_the_elimination() -> None:
    model = Model.of(arch(0.15, 12), friction=0.9)
    walk = followed(lambda: check(model), ELIMINATION)
    assert walk.way[0] == "check"
    assert 1 < len(walk.way) <= walk.deepest
    assert walk.hops < walk.calls
    assert len(walk.files) < len(walk.codes)
