"""Is the package no bigger than .ci/size.toml says? Tells what grew, and exits with 1; else with 0.

python .ci/size.py [--table]

What a reader has to hold in the head is counted: lines of code (without blanks, comments and
docstrings), files, numeric constants at module level, fields of dataclasses, and functions of
cyclomatic complexity above 10. ``--table`` counts every folder.
"""

import ast
import io
import sys
import tokenize
import tomllib
from collections import Counter, defaultdict
from pathlib import Path

COUNTED = ("code", "files", "constants", "fields", "complex")
NAMES = {
    "code": "lines of code",
    "files": "files",
    "constants": "numeric constants at module level",
    "fields": "fields of dataclasses",
    "complex": "functions of complexity above 10",
}
COMPLEX = 10
BELOW = 0.97
"""Below this share of a bound the bound can be lowered."""

_FUNCTION = (ast.FunctionDef, ast.AsyncFunctionDef)
_BRANCH = (
    *(ast.If, ast.For, ast.While, ast.ExceptHandler, ast.IfExp),
    *(ast.comprehension, ast.Assert, ast.match_case),
)
_NO_CODE = (
    *(tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE),
    *(tokenize.INDENT, tokenize.DEDENT, tokenize.ENDMARKER),
)


def size_of(source: str) -> Counter[str]:
    """What one file has of each."""
    tree = ast.parse(source)
    nodes = list(ast.walk(tree))
    functions = [node for node in nodes if isinstance(node, _FUNCTION)]
    return Counter(
        code=_code_lines(source, nodes),
        files=1,
        constants=sum(_is_constant(node) for node in tree.body),
        fields=sum(_fields(node) for node in nodes if isinstance(node, ast.ClassDef)),
        complex=sum(_complexity(function) > COMPLEX for function in functions),
    )


def _code_lines(source: str, nodes: list[ast.AST]) -> int:
    told: set[int] = set()
    for node in nodes:
        if isinstance(node, (ast.Module, ast.ClassDef, *_FUNCTION)) and ast.get_docstring(
            node, clean=False
        ):
            told.update(range(node.body[0].lineno, (node.body[0].end_lineno or 0) + 1))
    code: set[int] = set()
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.type not in _NO_CODE:
            code.update(range(token.start[0], token.end[0] + 1))
    return len(code - told)


def _complexity(function: ast.AST) -> int:
    found = 1
    for node in ast.walk(function):
        if isinstance(node, ast.BoolOp):
            found += len(node.values) - 1
        found += isinstance(node, _BRANCH)
    return found


def _fields(node: ast.ClassDef) -> int:
    if not any("dataclass" in ast.unparse(one) for one in node.decorator_list):
        return 0
    return sum(isinstance(one, ast.AnnAssign) for one in node.body)


def _is_constant(node: ast.stmt) -> bool:
    """Whether a statement of a module gives a name in capitals a value with numbers, no text."""
    if isinstance(node, ast.Assign):
        target: ast.expr = node.targets[0]
    elif isinstance(node, ast.AnnAssign) and node.value is not None:
        target = node.target
    else:
        return False
    parts = target.elts if isinstance(target, ast.Tuple) else [target]
    names = [one.id for one in parts if isinstance(one, ast.Name)]
    if not names or not all(name.lstrip("_").isupper() for name in names):
        return False
    assert node.value is not None
    values = [one.value for one in ast.walk(node.value) if isinstance(one, ast.Constant)]
    numbers = any(type(value) in (int, float) for value in values)
    return numbers and not any(isinstance(value, str) for value in values)


def sizes(package: Path) -> dict[str, Counter[str]]:
    """Of each folder of a package."""
    found: dict[str, Counter[str]] = defaultdict(Counter)
    for path in sorted(package.rglob("*.py")):
        inside = path.relative_to(package).parts
        found[inside[0] if len(inside) > 1 else "."].update(size_of(path.read_text("utf-8")))
    return found


def sentences(total: Counter[str], bounds: dict[str, int]) -> tuple[list[str], list[str]]:
    """What is too big, and which bounds can be lowered."""
    grown, lower = [], []
    for what in COUNTED:
        now, most = total[what], bounds[what]
        if now > most:
            grown.append(
                f"{NAMES[what]}: {now:,}, {now - most:,} more than the {most:,} of .ci/size.toml. "
                f"Take something away; or raise '{what}' there, and say why in the commit."
            )
        elif now < BELOW * most:
            lower.append(f"{NAMES[what]}: {now:,}. '{what}' in .ci/size.toml can be {now}.")
    return grown, lower


def main() -> int:
    """Count the package beside this folder."""
    root = Path(__file__).parents[1]
    folders = sizes(root / "src" / "drystone")
    total = sum(folders.values(), Counter())
    if "--table" in sys.argv[1:]:
        print(f"{'':14}" + "".join(f"{what:>10}" for what in COUNTED))
        for name, row in sorted(folders.items(), key=lambda one: -one[1]["code"]):
            print(f"{name:14}" + "".join(f"{row[what]:10,}" for what in COUNTED))
    bounds = tomllib.loads((root / ".ci" / "size.toml").read_text("utf-8"))
    grown, lower = sentences(total, bounds)
    print(", ".join(f"{total[what]:,} {what}" for what in COUNTED))
    print("\n".join([*grown, *lower]), end="\n" if grown or lower else "")
    return 1 if grown else 0


if __name__ == "__main__":
    sys.exit(main())
