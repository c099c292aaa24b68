"""Environments in which a model is put up block by block: what stands is what a check says."""

import re
import warnings
from pathlib import Path

import numpy as np
import pytest

gymnasium = pytest.importorskip("gymnasium")

from gymnasium.utils.env_checker import check_env  # noqa: E402

import drystone  # noqa: E402
from drystone import InputError, Model, Structure, check  # noqa: E402
from drystone.gym import (  # noqa: E402
    AssemblyEnv,
    BuildingOptions,
    assembly_envs,
    expert_actions,
)
from drystone.limits import Imperfections  # noqa: E402
from drystone.models import arch, shelf, tower  # noqa: E402
from drystone.sequence import Robot, Rules  # noqa: E402

PAGE = Path(__file__).parents[3] / "docs" / "how-to" / "learners.md"
ARCH = Model.of(arch(0.3, 5), friction=0.7)


def env_of(given: object = ARCH, **options: object) -> AssemblyEnv:
    return AssemblyEnv(given, options=BuildingOptions(**options))


@pytest.mark.parametrize(
    "options", [{}, {"noise": Imperfections(tolerance=0.002)}], ids=["exact", "noise"]
)
def test_it_passes_the_checker_of_gymnasium(options):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(env_of(**options), skip_render_check=True)


def test_gymnasium_makes_it_by_its_name():
    made = gymnasium.make("drystone.gym:drystone/Assembly-v0", given=ARCH)
    assert isinstance(made.unwrapped, AssemblyEnv)


@pytest.mark.parametrize("seed", range(4))
def test_every_verdict_is_that_of_a_check_and_the_reward_tells_the_friction_left(seed):
    structure, env = Structure(ARCH), env_of()
    (state, info), ended = env.reset(), False
    draw = np.random.default_rng(seed)
    while not ended:
        assert info["action_mask"].dtype == np.int8
        state, reward, ended, _, info = env.step(
            int(draw.choice(np.flatnonzero(info["action_mask"])))
        )
        free = ARCH.assembly.free
        fixed = [*np.flatnonzero(ARCH.assembly.fixed), *free[state == 2]]
        there = np.flatnonzero(ARCH.assembly.fixed | np.isin(np.arange(len(ARCH)), free[state > 0]))
        assert info["verdict"] == check(ARCH.with_supports(fixed).subset(there)).verdict.value
        margin = structure.stands(free[state > 0], held=free[state == 2]).friction_left
        if info["failed"]:
            assert reward == -1.0
        else:
            assert reward == pytest.approx(margin / 5 + ended, abs=1e-3)


def test_what_cannot_be_placed_is_masked_and_ends_the_episode():
    env = env_of(tower(4))
    _, info = env.reset()
    assert not info["action_mask"][env.action("block-2")]  # nothing is below it
    assert info["action_mask"][env.action("block-2", hold=1)]
    _, reward, ended, _, info = env.step(env.action("block-2"))
    assert (reward, ended, info["failed"]) == (-1.0, True, "the block cannot be placed")
    assert not info["action_mask"].any()
    first = env_of(tower(4), rules=Rules(before=[("block-1", "block-2")]))
    assert not first.reset()[1]["action_mask"][first.action("block-2", hold=1)]
    wide = env_of(shelf())
    with pytest.raises(InputError, match="no block to place"):
        wide.action(int(np.flatnonzero(wide.structure.model.assembly.fixed)[0]))
    with pytest.raises(InputError, match="hold is 2; give 0 to 1"):
        env.action("block-1", hold=2)


def test_a_block_comes_in_only_where_no_joint_is_in_the_way():
    env = env_of(tower(4), directions=[(0.0, 0.0, -2.0), (0.0, 0.0, 1.0), (1.0, 0.0, 0.0)])
    mask = env.reset()[1]["action_mask"]
    assert [mask[env.action("block-1", way)] for way in range(3)] == [1, 0, 1]
    with pytest.raises(InputError, match="has no length"):
        BuildingOptions(directions=[(0.0, 0.0, 0.0)])


def test_a_robot_that_holds_cannot_place_and_lets_go_when_it_is_needed():
    team = [Robot("left"), Robot("right"), Robot("weak", payload=1e-3)]
    env = env_of(rules=Rules(robots=team[:2]))
    env.reset()
    state, *_, info = env.step(env.action("voussoir-01", robot=1, hold=1))
    assert state.tolist() == [0, 3, 0, 0, 0]
    assert not info["action_mask"][env.action("voussoir-00", robot=1)]
    state, *_ = env.step(env.action("voussoir-02", robot=0, hold=1))
    assert state.tolist() == [0, 1, 2, 0, 0]  # one hand must be free for the next block
    weak = env_of(rules=Rules(robots=team))
    assert not weak.reset()[1]["action_mask"][weak.action("voussoir-00", robot=2)]
    alone = env_of(rules=Rules(hands=1))
    assert alone.action_space.n == 5


def test_noise_is_drawn_anew_in_each_episode_and_again_with_the_same_seed():
    rules = Rules(hands=3)
    env, exact = env_of(noise=Imperfections(tolerance=0.005), rules=rules), env_of(rules=rules)
    actions = expert_actions(env)

    def rewards(env: AssemblyEnv, seed: int) -> list[float]:
        env.reset(seed=seed)
        return [env.step(action)[1] for action in actions]

    first = rewards(env, 1)
    assert rewards(env, 2) != first
    assert rewards(env, 1) == first
    assert rewards(exact, 1) == rewards(exact, 2) != first


def test_several_share_what_one_finds_out():
    structure = Structure(ARCH)
    envs = assembly_envs(structure, 3, options=BuildingOptions(rules=Rules(hands=3)))
    state, info = envs.reset(seed=1)
    assert (state.shape, info["action_mask"].shape) == ((3, 5), (3, 10))
    actions = np.zeros(3, dtype=int)
    state, reward, *_, info = envs.step(actions)
    assert state.tolist() == [[1, 0, 0, 0, 0]] * 3
    assert reward.tolist() == [reward[0]] * 3
    assert all(one.structure is structure for one in envs.envs)


@pytest.mark.parametrize(
    ("given", "options"),
    [
        (ARCH, {"rules": Rules(hands=3)}),
        (ARCH, {"rules": Rules(robots=[Robot("a"), Robot("b"), Robot("c")])}),
        (tower(4), {"directions": [(1.0, 0.0, 0.0), (0.0, 0.0, -1.0)]}),
    ],
)
def test_the_order_of_the_planner_completes_the_model(given, options):
    env = env_of(given, **options)
    env.reset()
    ends = [env.step(action) for action in expert_actions(env)]
    assert [one[2] for one in ends] == [False] * (len(ends) - 1) + [True]
    assert ends[-1][4]["failed"] == ""
    assert ends[-1][1] > 1.0


def test_a_model_that_needs_props_has_no_order_for_hands():
    with pytest.raises(InputError, match="it props 'voussoir"):
        expert_actions(env_of(rules=Rules(hands=2)))


def test_the_policy_of_the_page_learns_what_the_page_says(capsys):
    (code,) = re.findall(r"^```python\n(.*?)^```$", PAGE.read_text("utf-8"), re.M | re.S)
    exec(code, {})
    printed = capsys.readouterr().out.strip()
    assert f"It prints `{printed}`" in PAGE.read_text("utf-8")


def test_its_repr_is_short_and_it_is_listed():
    assert repr(BuildingOptions()).count("\n") == 0
    assert {*drystone.gym.__all__} >= {"AssemblyEnv", "assembly_envs", "expert_actions"}
