"""Full disks and killed processes: every command leaves whole files, or none, and goes on rightly.

``python -m benchmarks.interrupted disks|kills [--only PATTERN] [--times 10] [--seed 0]``

The commands and what they write are taken from the command line itself, so a new command or a new
file is run too. ``disks`` lets each command write each of its files, in each of their formats, to a
disk that is full from the first byte, and to one with 4 KiB left, over a file that is there (a
mounted tmpfs; who may not mount one gets a limit on the size of a file). ``kills`` sends SIGINT,
SIGTERM, SIGHUP and SIGKILL to each command at random moments, then runs it again.

Each run is a fork of a process that has drystone loaded. ``kills --fresh`` starts a new Python for
each, so that a signal may come while it starts and ends, too.
"""

from __future__ import annotations

import argparse
import contextlib
import faulthandler
import json
import math
import os
import random
import resource
import select
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import click

import drystone
from drystone.cli import main as program
from drystone.cli.application import app
from drystone.cli.command import Command
from drystone.io import FORMATS
from drystone.models import arch, tower, wall

GIVEN = {
    "check": "tower.json",
    "combine": "tower.json cases.toml",
    "convert": "tower.json",
    "cut": "tower.json --block block-1 --blocks 2",
    "demo": "",
    "fall": "tower.json --seismic 0.4 --duration 0.1",
    "inspect": "tower.json",
    "gravity": "pair.json --directions 6",
    "interlock": "pair.json",
    "limit decay": "pair.json",
    "limit friction": "pair.json",
    "limit imperfections": "tower.json --offset 0.01 --draws 2",
    "limit load": "pair.json block-1:1kN@0,0,1",
    "limit shrink": "pair.json",
    "limit strength": "pair.json --strength 1MPa",
    "limit sweep": "pair.json --directions 2",
    "limit thickness": "arch --set voussoirs=4 --scan 2 --width 0.1",
    "limit thrust": "pair.json block-0",
    "limit tilt": "pair.json",
    "limit train": "arch.json --steps 2",
    "live": "tower.json --no-browser --port 0",
    "mcp": ".",
    "mend": "pair.json --seismic 0.3 --friction 0.2 --kind friction",
    "models": "tower --set count=3",
    "plan": "tower.json",
    "poses": "tower.json --block block-1",
    "push": "pair.json --to 0.001",
    "recut": "tower.json --most 1",
    "reproduce": "5.1.1",
    "scaffold": "pair.json --time-limit 1",
    "settle": "tower.json --move block-0:0,0,-0.001 --to 0.001",
    "shape": "tower.json --seismic 0.51 --most 0.5 --time-limit 1",
    "sharpen": "tower.json --seismic 0.65 --most 20",
    "shell": "barrel --courses 3 --blocks 2 --thickness 0.6",
    "study": "tower --set count=2 --set count=3 --set friction=0.6 --set friction=0.8 --limit tilt",
    "tune": "tower --set count=2 --vary edge=0.5:1 --trials 3",
}
"""What each command is asked; of others the first example is taken, with the files left out."""
LONGER = {
    "check": "wall.json --strict",
    "limit friction": "arch.json",
    "limit sweep": "arch.json --scan 8 --directions 4",
    "mend": "arch.json --friction 0.3 --auto",
    "plan": "arch.json",
    "shape": "arch.json --friction 0.8 --most 0.05 --time-limit 3",
    "tune": "arch --set voussoirs=6 --vary thickness_ratio=0.05:0.3 --friction 0.8 --trials 12",
    "shell": "barrel --courses 5 --blocks 2 --thickness 0.6 --buildable",
}
"""What it is asked where it is to take a while."""
NEEDED = {
    ("mend", "out"): "--auto",
    ("settle", "joints"): "",
    ("settle", "corners"): "",
    ("settle", "cad"): "",
}
"""What some files need besides."""
INSTEAD = {("settle", "joints"), ("settle", "corners"), ("settle", "cad")}
"""Files of the motion by small steps only: without its last option."""
NONE = {(name, "csv") for name in ("forces", "interlock", "limit thrust", "mend")}
"""Tables of answers that have none, or not always."""
TIMES = {"checks", "made"}
"""What an answer says of its work, not of the model, beside times."""
LIST = {("mend", "pages")}
"""Files of the list of mends, which is not there where one is made."""
JOURNALS = {"checkpoint", "store", "dataset out", "study out"}
"""Options, or commands and options, of files that grow."""
SERVERS = {"live", "mcp"}
SLOW = {"png", "client"}
"""Files that are left out when commands are killed: drawing takes longer than the work."""
OLD = b"what was there before\n"
ASKED = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
PATIENCE_S = 30.0
"""[s] of calculation, or of waiting, after which a run hangs."""
IDLE_S = 0.1
"""[CPU s] Who uses less in that time only waits."""
PAGE = 4096
"""[bytes] of a block of the disk."""


@dataclass(frozen=True)
class Case:
    """A command that writes one file.

    Attributes
    ----------
    command
    option
        By which the file is named.
    words
        All that is given.
    name
        Of the file, or the folder.
    """

    command: str
    option: str
    words: tuple[str, ...]
    name: str

    @property
    def is_journal(self) -> bool:
        """Whether its file grows, record by record."""
        return not JOURNALS.isdisjoint((self.option, f"{self.command} {self.option}"))


def commands(group: click.Group = app, before: tuple[str, ...] = ()) -> dict[str, Command]:
    """Every command by its words."""
    found: dict[str, Command] = {}
    context = click.Context(group)
    for name in group.list_commands(context):
        one = group.get_command(context, name)
        if isinstance(one, click.Group):
            found |= commands(one, (*before, name))
        elif isinstance(one, Command):
            found[" ".join((*before, name))] = one
    return found


def files_of(name: str, one: Command) -> list[tuple[click.Parameter, tuple[str, ...]]]:
    """The options by which a command is given files to write, and their suffixes."""
    models = tuple(dict.fromkeys(f.suffixes[0] for f in FORMATS if f.writer and f.suffixes))
    return [
        (param, models if name == "convert" else param.type.written)
        for param in one.params
        if getattr(param.type, "written", ())
    ]


def asked(name: str, one: Command) -> list[str]:
    """What a command is asked, without files to write."""
    if name in GIVEN:
        return shlex.split(GIVEN[name])
    words = shlex.split(one.examples[0])[1 + len(name.split()) :]
    writing = {flag for param, _ in files_of(name, one) for flag in param.opts}
    kept = [word for i, word in enumerate(words) if i == 0 or words[i - 1] not in writing]
    return [word for word in kept if word not in writing]


def cases(only: str = "", every_suffix: bool = True) -> list[Case]:
    """Every command with each file that it writes, in each format."""
    found = []
    for name, one in commands().items():
        for param, suffixes in files_of(name, one):
            option = str(param.name)
            if (name, option) in NONE:
                continue
            given = asked(name, one)
            if (name, option) in INSTEAD:
                given = given[:-2]
            given += shlex.split(NEEDED.get((name, option), ""))
            if not every_suffix:
                suffixes = suffixes[:1]
            for suffix in suffixes:
                target = "disk" if option == "folder" else f"disk/made{suffix}"
                flag = [] if isinstance(param, click.Argument) else [max(param.opts, key=len)]
                words = (*name.split(), *given, *flag, target)
                found.append(Case(name, option, words, Path(target).name))
    return [case for case in found if only in " ".join(case.words)]


def models_in(folder: Path) -> None:
    """Write the models that the commands are asked about."""
    made = {"pair": tower(2), "tower": tower(3), "wall": wall(4, 6), "arch": arch(voussoirs=8)}
    for name, assembly in made.items():
        drystone.write(drystone.Model.of(assembly), folder / f"{name}.json")
    cases = '[case.weight]\nkind = "permanent"\nload = "gravity"\n'
    (folder / "cases.toml").write_text(cases, encoding="utf-8")


def left_by(case: Case, code: int, told: str, before: dict[str, bytes], disk: Path) -> str:
    """What is wrong after a run whose disk was full; empty where nothing is."""
    after = tree(disk)
    if any(".drystone-" in name for name in after):
        return "left a temporary folder"
    if code in (0, 1) and after != before:
        return ""  # the file is smaller than what was free
    if code != 2:
        return f"ended with {code}: {told}"
    if told.count("\n") != 1 or "Traceback" in told:
        return f"told in {told.count(chr(10))} lines: {told}"
    if Path(case.name).stem not in told or not (
        "No space left" in told or "File too large" in told
    ):
        return f"does not name the file, or the disk: {told}"
    if case.is_journal:
        kept = [one for one in after.values() if one not in (b"", b"folder")]
        if not all(one.endswith(b"\n") for one in kept):
            return "left half a record"
    elif after != before:
        return f"left {sorted(name for name in after if after[name] != before.get(name))}"
    return ""


def tree(folder: Path) -> dict[str, bytes]:
    """Every file and folder below one, with the bytes of files."""
    return {
        one.relative_to(folder).as_posix(): one.read_bytes() if one.is_file() else b"folder"
        for one in sorted(folder.rglob("*"))
        if one.name != "taken"
    }


@contextlib.contextmanager
def full_disk(disk: Path, free: int) -> Iterator[None]:
    """Leave so many bytes on a mounted disk."""
    taken = disk / "taken"
    with taken.open("wb", buffering=0) as file, contextlib.suppress(OSError):
        while True:
            file.write(bytes(PAGE))
    os.truncate(taken, taken.stat().st_size - free)
    try:
        yield
    finally:
        taken.unlink()


@contextlib.contextmanager
def small_files(_: Path, free: int) -> Iterator[None]:
    """Let no file of this process grow larger; the system says so as of a full disk.

    Python would keep cut bytecode of what is imported meanwhile.
    """
    before, silent = resource.getrlimit(resource.RLIMIT_FSIZE), sys.dont_write_bytecode
    sys.dont_write_bytecode = True
    resource.setrlimit(resource.RLIMIT_FSIZE, (free, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
        sys.dont_write_bytecode = silent


@dataclass
class Ended:
    """How a run ended: exit code, stdout, stderr, wall time [s]."""

    code: int
    out: str
    told: str
    wall_s: float = 0.0
    strays: list[int] = field(default_factory=list)


def forked(work: Callable[[], int], folder: Path, after_s: float = -1.0, number: int = 0) -> Ended:
    """Run work in a fork, in a folder, with a session of its own, and send it a signal."""
    ready, told = os.pipe()
    silent, never = os.pipe()  # a standard input on which nothing comes
    out, err = folder.parent / "stdout", folder.parent / "stderr"
    signal.pthread_sigmask(signal.SIG_BLOCK, ASKED)
    child = os.fork()
    if child == 0:
        code = 70
        try:
            os.close(never)
            os.setsid()
            os.chdir(folder)
            sys.stdout, sys.stderr = (path.open("w", encoding="utf-8") for path in (out, err))
            for place, descriptor in enumerate((silent, sys.stdout.fileno(), sys.stderr.fileno())):
                os.dup2(descriptor, place)
            faulthandler.register(signal.SIGUSR1, all_threads=True)  # says where it hangs
            os.write(told, b".")
            signal.pthread_sigmask(signal.SIG_UNBLOCK, ASKED)
            code = work()
            signal.pthread_sigmask(signal.SIG_BLOCK, ASKED)
        finally:
            for stream in (sys.stdout, sys.stderr):
                with contextlib.suppress(OSError, ValueError):
                    stream.flush()
            os._exit(code)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, ASKED)
    os.close(told)
    select.select([ready], [], [], 10.0)
    try:
        return _ended(child, out, err, after_s, number)
    finally:
        for one in (ready, silent, never):
            os.close(one)


def started(words: Sequence[str], folder: Path, after_s: float = -1.0, number: int = 0) -> Ended:
    """Run a command in a new Python, and send it a signal."""
    out, err = folder.parent / "stdout", folder.parent / "stderr"
    with out.open("w") as file, err.open("w") as other:
        run = subprocess.Popen(
            [sys.executable, "-m", "drystone", *words],
            cwd=folder, stdin=subprocess.PIPE, stdout=file, stderr=other, start_new_session=True,
        )  # fmt: skip
        try:
            return _ended(run.pid, out, err, after_s, number)
        finally:
            if run.stdin is not None:
                run.stdin.close()
            run.returncode = 0  # it was waited for


def _ended(child: int, out: Path, err: Path, after_s: float, number: int) -> Ended:
    begin = time.monotonic()
    if number:
        time.sleep(after_s)
        os.kill(child, number)
    status = _waited(child, PATIENCE_S)
    wall_s = time.monotonic() - begin
    if status is None:
        os.kill(child, signal.SIGUSR1)
        time.sleep(1.0)
        for one in _session(child):
            os.kill(one, signal.SIGKILL)
        os.waitpid(child, 0)
        return Ended(70, "", f"hangs: {err.read_text(encoding='utf-8')}", wall_s)
    code = os.waitstatus_to_exitcode(status)
    strays = _session(child)
    end = time.monotonic() + PATIENCE_S
    while strays and time.monotonic() < end:
        time.sleep(0.05)
        strays = _session(child)
    for one in strays:
        with contextlib.suppress(ProcessLookupError):
            os.kill(one, signal.SIGKILL)
    said = (path.read_text(encoding="utf-8", errors="replace") for path in (out, err))
    return Ended(code, *said, wall_s, [*strays])


def _waited(child: int, limit_s: float) -> int | None:
    """The status with which a process ends; none where it hangs.

    It hangs where it calculates for so long, or where it waits for so long: on a busy machine
    it may take any time.
    """
    since, before_s = time.monotonic(), 0.0
    while True:
        done, status = os.waitpid(child, os.WNOHANG)
        if done:
            return status
        if time.monotonic() - since > limit_s:
            used_s = sum(_session(child).values())
            if used_s > limit_s or used_s - before_s < IDLE_S:
                return None
            since, before_s = time.monotonic(), used_s
        time.sleep(0.005)


def _session(leader: int) -> dict[int, float]:
    """Processes of a session that still run, with their CPU times and those of ended children."""
    found = {}
    for one in Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError, ValueError, IndexError):
            told = (one / "stat").read_text().rpartition(")")[2].split()
            if int(told[3]) == leader and told[0] != "Z":
                found[int(one.name)] = sum(map(int, told[11:15])) / os.sysconf("SC_CLK_TCK")
    return found


def disks(only: str = "") -> list[tuple[Case, str]]:
    """Run every case on a full disk; what was wrong with each."""
    found = []
    with tempfile.TemporaryDirectory() as place:
        folder, disk = Path(place) / "work", Path(place) / "work" / "disk"
        disk.mkdir(parents=True)
        models_in(folder)
        mount = ["mount", "-t", "tmpfs", "-o", "size=4m", "tmpfs", str(disk)]
        mounted = subprocess.run(mount, check=False, capture_output=True).returncode == 0
        limited = full_disk if mounted else small_files
        print(f"on {'a tmpfs of 4 MiB' if mounted else 'a limit of the size of files'}")
        try:
            for case in cases(only):
                for free in (0, PAGE):
                    found.append((case, _on_full(case, folder, limited, free)))
        finally:
            if mounted:
                subprocess.run(["umount", str(disk)], check=True)
    return found


def _on_full(case: Case, folder: Path, limited: Any, free: int) -> str:
    disk = folder / "disk"
    for one in disk.iterdir():
        shutil.rmtree(one) if one.is_dir() else one.unlink()
    if "." in case.name and not case.is_journal:
        (disk / case.name).write_bytes(OLD)
    before = tree(disk)
    if limited is full_disk:
        with full_disk(disk, free):
            ended = forked(lambda: program(case.words), folder)
    else:
        ended = forked(lambda: _limited(case, disk, free), folder)
    wrong = "" if ended.code == 3 else left_by(case, ended.code, ended.told, before, disk)
    if not wrong and ended.code == 2:
        again = forked(lambda: program(case.words), folder)
        if again.code not in (0, 1):
            wrong = f"with space again: {again.code}: {again.told}"
    print(f"{ended.code} {free:4} {' '.join(case.words)} {wrong}", flush=True)
    return wrong


def _limited(case: Case, disk: Path, free: int) -> int:
    with small_files(disk, free):
        return program(case.words)


def kill_cases(only: str = "") -> list[Case]:
    """Every command with all files that it writes, and what programs call."""
    found = []
    for name, one in commands().items():
        words = name.split() + (shlex.split(LONGER[name]) if name in LONGER else asked(name, one))
        journal = ""
        for param, suffixes in files_of(name, one):
            option = str(param.name)
            needed = shlex.split(NEEDED.get((name, option), ""))
            if option in SLOW or (name, option) in INSTEAD | LIST or not {*needed[:1]} <= {*words}:
                continue
            target = "disk" if option == "folder" else f"disk/{option}{suffixes[0]}"
            flag = [] if isinstance(param, click.Argument) else [max(param.opts, key=len)]
            words += [*flag, target]
            journal = option if Case(name, option, (), "").is_journal else journal
        found.append(
            Case(name, journal, (*words, *([] if name in SERVERS else ["--json"])), journal)
        )
    found += [Case(name, "store", (name,), "store") for name in CALLS]
    found.sort(key=lambda case: case.command not in {*LONGER, *CALLS, *SERVERS})
    return [case for case in found if only in " ".join(case.words)]


def _check_many() -> int:
    models = [tower(1 + i % 6) for i in range(24)]
    found = drystone.check_many(models, out="disk/store", friction=0.6)
    print(json.dumps([str(one) for one in found["verdict"]]))
    return 0


CALLS = {"check_many(out=...)": _check_many}
"""What programs call, and goes on from a file."""


def kills(
    only: str = "", times: int = 10, seed: int = 0, fresh: bool = False
) -> dict[str, tuple[Counter[str], list[str]]]:
    """Send every command every signal at random moments; what came of it, by command."""
    found: dict[str, tuple[Counter[str], list[str]]] = {}
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place) / "work"
        (folder / "disk").mkdir(parents=True)
        models_in(folder)
        for case in kill_cases(only):
            if fresh and case.command in CALLS:
                continue
            counts, wrong = found[case.command] = _killed(case, folder, times, seed, fresh)
            told = ", ".join(f"{key} {count}" for key, count in counts.items())
            print(f"{case.command}: {told} {'; '.join(wrong)[:9000]}", flush=True)
    return found


def _work(case: Case) -> int:
    if case.command not in CALLS:
        return program(case.words)
    try:
        return CALLS[case.command]()
    except KeyboardInterrupt:
        return 130


def _killed(
    case: Case, folder: Path, times: int, seed: int, fresh: bool
) -> tuple[Counter[str], list[str]]:
    disk, rng = folder / "disk", random.Random(f"{seed}-{case.command}")
    counts: Counter[str] = Counter()
    wrong: list[str] = []

    def once(after_s: float = -1.0, number: int = 0) -> Ended:
        if fresh:
            return started(case.words, folder, after_s, number)
        return forked(lambda: _work(case), folder, after_s, number)

    def cleared() -> None:
        shutil.rmtree(disk)
        disk.mkdir()

    cleared()
    whole = None if case.command in SERVERS else once()
    counts["untouched"] = 0 if whole is None else whole.code
    made = tree(disk)
    for number in (*ASKED, signal.SIGKILL):
        for _ in range(times):
            cleared()
            after_s = rng.uniform(0.0, 2.0 if whole is None else whole.wall_s)
            ended = once(after_s, number)
            when = f"{number.name} after {after_s:.3f} s"
            counts[f"{number.name} {ended.code}"] += 1
            may = number == signal.SIGKILL or fresh or case.command in CALLS
            usual = {130, 0 if whole is None else whole.code, *([-number] if may else [])}
            if ended.code not in usual:
                wrong.append(f"{when}: {ended.code} {ended.told[-2000:]}")
            wrong += [f"{when}: {one}" for one in _left(ended, number, disk, made)]
            if ended.code == 130 and whole is not None and not _is_json(ended.out):
                wrong.append(f"{when}: half an answer")
            left = any(".drystone-" in name for name in tree(disk))
            if whole is None or not (left or case.is_journal):
                continue
            again = once()
            counts["again"] += 1
            if rest := [name for name in tree(disk) if ".drystone-" in name]:
                wrong.append(f"{when}, again: left {rest}")
            differs = different(answered(again.out), answered(whole.out))
            if again.code != whole.code or differs:
                wrong.append(f"{when}, again: {again.code} {again.told}{differs}")
    return counts, wrong


def _left(ended: Ended, number: int, disk: Path, made: dict[str, bytes]) -> list[str]:
    """What is wrong with what a signal left."""
    wrong = []
    if "Traceback" in ended.told or "a fault in" in ended.told:
        wrong.append(f"told {ended.told[-300:]}")
    if ended.strays:
        wrong.append(f"{len(ended.strays)} processes went on")
    for name, data in tree(disk).items():
        if ".drystone-" in name:
            if number != signal.SIGKILL:
                wrong.append(f"left {name}")
        elif not is_whole(name, data) and data != made.get(name):
            wrong.append(f"half of {name}")
    return wrong


def _is_json(text: str) -> bool:
    try:
        json.loads(text or "{}")
    except ValueError:
        return False
    return True


def is_whole(name: str, data: bytes) -> bool:
    """Whether a file is complete, by what its format ends with."""
    suffix = Path(name).suffix
    if suffix == ".json":
        return data.rstrip()[-1:] in (b"}", b"]")
    if suffix in (".html", ".htm", ".svg"):
        return data.rstrip().endswith((b"</html>", b"</svg>"))
    if suffix == ".png":
        return data.endswith(b"IEND\xaeB`\x82")
    if suffix == ".gif":
        return data.endswith(b";")
    if suffix == ".glb":
        return int.from_bytes(data[8:12], "little") == len(data)
    return suffix in ("", ".3dm") or data.endswith(b"\n")


def answered(text: str) -> Any:
    """An answer as JSON, without what differs from run to run: times and counts of work."""
    try:
        return _timeless(json.loads(text))
    except ValueError:
        return text


def different(one: Any, other: Any, place: str = "answer") -> str:
    """Where two answers differ first by more than rounding, and how; empty where they do not."""
    if isinstance(one, dict) and isinstance(other, dict) and one.keys() == other.keys():
        parts = [different(one[key], other[key], f"{place}.{key}") for key in one]
    elif isinstance(one, list) and isinstance(other, list) and len(one) == len(other):
        pairs = enumerate(zip(one, other, strict=True))
        parts = [different(*pair, f"{place}[{number}]") for number, pair in pairs]
    elif (
        isinstance(one, float)
        and isinstance(other, float)
        and math.isclose(one, other, rel_tol=1e-6, abs_tol=1e-6)
    ):
        parts = []
    else:
        parts = [f"{place} is {str(one)[:60]}, not {str(other)[:60]}"] if one != other else []
    return next(filter(None, parts), "")


def _timeless(value: Any) -> Any:
    if isinstance(value, dict):
        left = {key: one for key, one in value.items() if key not in TIMES and key[-2:] != "_s"}
        return {key: _timeless(one) for key, one in left.items()}
    return [*map(_timeless, value)] if isinstance(value, list) else value


def main() -> int:
    """Run, print what came of it, and fail where something was wrong."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("what", choices=("disks", "kills"))
    parser.add_argument("--only", default="")
    parser.add_argument("--times", type=int, default=10)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--fresh", action="store_true")
    chosen = parser.parse_args()
    signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell may let it be ignored
    if chosen.what == "disks":
        told = disks(chosen.only)
        wrong = [(case, one) for case, one in told if one]
        print(f"{len(told)} runs of {len({case.command for case, _ in told})} commands")
        print(f"{len(wrong)} failures")
        return 1 if wrong else 0
    found = kills(chosen.only, chosen.times, chosen.seed, chosen.fresh)
    sent = sum(n for counts, _ in found.values() for key, n in counts.items() if key != "again")
    failures = [one for _, wrong in found.values() for one in wrong]
    print(f"{sent} signals to {len(found)} commands; {len(failures)} failures")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
