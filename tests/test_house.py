"""The walls of the house: what may import what, how long things may be, and how they are named."""

from __future__ import annotations

import ast
import sys
import tomllib
from collections.abc import Iterator
from fnmatch import fnmatch
from functools import cache
from pathlib import Path

import pytest

import gcodesim
from gcodesim.findings import CODES, FAIL, INCONCLUSIVE, NOTED
from gcodesim.nc.meanings import MEANINGS

ROOT = Path(__file__).parents[1]
FILES = sorted(path.relative_to(ROOT).as_posix() for path in ROOT.glob("gcodesim/**/*.py"))

THIRD_PARTY = {
    "click": ["gcodesim/cli/*"],
    "rich": ["gcodesim/cli/*", "gcodesim/report/*"],
    "trimesh": ["gcodesim/machine/mesh.py"],
    "yaml": ["gcodesim/machine/yaml_lines.py"],
    "pydantic": ["gcodesim/machine/*"],
    "pydantic_core": ["gcodesim/machine/*"],
    "warp": ["gcodesim/collision/*"],
    "matplotlib": ["gcodesim/report/study_plot.py"],
    "distributed": ["gcodesim/batch/cluster.py"],
    "numpy": ["gcodesim/*"],
}
"""Package -> the only files that may import it. What is not listed is imported nowhere."""

TYPES = {
    *("constants", "errors", "findings", "fingerprints", "options", "verdict"),
    *("nc.program", "machine.model"),
}
LAYERS = {
    "nc": TYPES - {"machine.model"},
    "machine": TYPES | {"nc"},
    "motion": TYPES | {"machine"},
    "collision": TYPES | {"machine", "motion"},
    "replay": TYPES | {"machine", "motion"},
    "report": TYPES - {"nc.program", "machine.model"}
    | {"explain", "__init__", "replay", "collision.rays", "collision.distances"},
    "policy": TYPES - {"nc.program", "machine.model"},
    "settings": {"errors"},
    "evidence": TYPES | {"nc", "machine", "motion", "collision"},
    "audit": TYPES | {"collision"},
    "lint": TYPES | {"machine", "motion", "collision"},
    "flow": TYPES | {"nc", "machine", "motion", "collision", "evidence", "audit", "replay"},
    "api": TYPES | {"nc", "machine", "flow", "policy"},
    "batch": TYPES | {"nc", "machine", "collision", "flow", "policy", "report", "__init__"},
    "starter": {"errors", "machine", "__init__"},
    "trace": TYPES | {"machine", "motion"},
    "study": TYPES | {"nc", "machine", "motion", "collision", "audit", "flow", "__init__"},
    "cli": TYPES
    | {
        *("nc", "machine", "motion", "report", "policy", "settings", "flow", "study", "trace"),
        *("lint", "batch", "starter", "explain", "__init__"),
    },
    "explain": TYPES | {"nc"},
    "__main__": {"cli"},
    "__init__": set(),
}
"""Layer -> what it may import besides itself; the types import only types."""


@cache
def tree(file: str) -> ast.Module:
    return ast.parse((ROOT / file).read_text(encoding="utf-8"))


def functions(file: str) -> Iterator[ast.FunctionDef]:
    return (node for node in ast.walk(tree(file)) if isinstance(node, ast.FunctionDef))


def decorators(function: ast.FunctionDef) -> str:
    return " ".join(ast.unparse(decorator) for decorator in function.decorator_list)


def is_kernel_file(file: str) -> bool:
    return any("wp.kernel" in decorators(f) or "wp.func" in decorators(f) for f in functions(file))


def imports(file: str, *, late: bool) -> Iterator[str]:
    """Names of the imported modules; `late` also those inside functions, never those for types."""
    pending: list[ast.AST] = list(tree(file).body)
    while pending:
        node = pending.pop()
        if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test):
            continue
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            below = [f"{node.module}.{alias.name}" for alias in node.names]
            modules = [name for name in below if module_file(name)]
            yield from modules or [node.module]
        elif late or not isinstance(node, ast.FunctionDef):
            pending += ast.iter_child_nodes(node)


def module_file(module: str) -> str | None:
    """File of a module of ours, None for all others."""
    path = module.replace(".", "/")
    return next((f for f in (f"{path}.py", f"{path}/__init__.py") if f in FILES), None)


def layer_names(file: str) -> set[str]:
    """Names by which LAYERS and TYPES may call a file: ``nc`` and ``nc.program``."""
    parts = file.removeprefix("gcodesim/").removesuffix(".py").split("/")
    return {parts[0], ".".join(parts)}


@pytest.mark.parametrize("file", FILES)
def test_third_party_packages_stay_behind_their_walls(file: str) -> None:
    packages = {name.partition(".")[0] for name in imports(file, late=True)}
    for package in packages - set(sys.stdlib_module_names) - {"gcodesim"}:
        allowed = THIRD_PARTY.get(package, [])
        assert any(fnmatch(file, pattern) for pattern in allowed), f"{package} in {file}"


@pytest.mark.parametrize("file", FILES)
def test_nothing_is_imported_upward(file: str) -> None:
    names = layer_names(file)
    own = names & TYPES or names & LAYERS.keys()
    assert own, f"{file} belongs to no layer"
    allowed = TYPES if names & TYPES else {*own, *LAYERS[own.pop()]}
    for module in imports(file, late=True):
        if target := module_file(module):
            assert layer_names(target) & allowed, f"{file} imports {target}"


def test_no_import_circles() -> None:
    graph = {
        file: {t for m in imports(file, late=False) if (t := module_file(m))} for file in FILES
    }
    while graph:
        leaves = {file for file, needed in graph.items() if not needed & graph.keys()}
        assert leaves, f"in a circle, or behind one: {', '.join(graph)}"
        graph = {file: needed for file, needed in graph.items() if file not in leaves}


@pytest.mark.parametrize("file", FILES)
def test_every_file_begins_with_its_sentence_and_stays_short(file: str) -> None:
    sentence = (ast.get_docstring(tree(file)) or "").partition("\n")[0]
    assert sentence[:1].isupper(), file
    assert sentence.endswith((".", ":", "?")), file
    text = (ROOT / file).read_text(encoding="utf-8")
    assert text.startswith(('"""', 'r"""')), file
    assert text.count("\n") <= 500, file
    for mark in ("TODO", "FIXME", "XXX", "HACK"):
        assert mark not in text, file


@pytest.mark.parametrize("file", FILES)
def test_functions_stay_short(file: str) -> None:
    for function in functions(file):
        assert function.end_lineno is not None
        assert function.end_lineno - function.lineno < 80, f"{file}: {function.name}"


def test_kernels_take_few_arguments_and_their_outputs_last() -> None:
    kernels = {
        f"{file}: {function.name}": [argument.arg for argument in function.args.args]
        for file in FILES
        for function in functions(file)
        if "wp.kernel" in decorators(function)
    }
    assert kernels
    for name, arguments in kernels.items():
        assert len(arguments) <= 8, name
        outputs = [argument.endswith("_out") for argument in arguments]
        assert outputs[-1], name
        assert outputs == sorted(outputs), name


def test_types_of_kernel_files_only_are_left_unchecked() -> None:
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["mypy"]
    (exempt,) = (o["module"] for o in settings["overrides"] if o.get("ignore_errors"))
    kernel_files = [file for file in FILES if is_kernel_file(file)]
    assert exempt == [file.removesuffix(".py").replace("/", ".") for file in kernel_files]


def test_public_names() -> None:
    stable = ("Finding", "Options", "Report", "UsageError", "check", "triangles_intersect")
    assert gcodesim.__all__ == sorted([*stable, "__version__"])
    for name in gcodesim.__all__:
        assert getattr(gcodesim, name)


def test_the_table_of_codes_is_whole() -> None:
    titles = [code.title for code in CODES.values()]
    assert len(titles) == len(set(titles))
    for code in CODES.values():
        assert code.severity in ("error", "warning", "note")
        assert code.effect in (FAIL, INCONCLUSIVE, NOTED)


@pytest.mark.parametrize("file", FILES)
def test_every_code_used_is_in_the_table(file: str) -> None:
    for node in ast.walk(tree(file)):
        text = node.value if isinstance(node, ast.Constant) else None
        if isinstance(text, str) and len(text) == 5 and text.startswith("GC"):
            assert text in CODES, f"{file}:{node.lineno}"


@pytest.mark.parametrize("file", ["gcodesim/findings.py", "gcodesim/nc/meanings.py"])
def test_no_code_or_meaning_is_given_twice(file: str) -> None:
    for node in ast.walk(tree(file)):
        if isinstance(node, ast.Dict):
            keys = [ast.unparse(key) for key in node.keys if key]
            assert len(keys) == len(set(keys))


def test_every_meaning_has_a_code_of_the_table() -> None:
    assert {code for code, _ in MEANINGS.values()} <= CODES.keys()
