"""The walls of the house: what may import what, how long things may be, and how they are named."""

from __future__ import annotations

import ast
import re
import sys
import tomllib
from collections.abc import Iterator
from fnmatch import fnmatch
from functools import cache
from pathlib import Path
from typing import TypeGuard

import pytest
from benchmarks.structure import structure

import gcodesim
from gcodesim.findings.codes import CODES, FAIL, INCONCLUSIVE, NOTED
from gcodesim.findings.meanings import MEANINGS
from gcodesim.nc.control.readings import ROWS

ROOT = Path(__file__).parents[1]
FILES = sorted(path.relative_to(ROOT).as_posix() for path in ROOT.glob("gcodesim/**/*.py"))

THIRD_PARTY = {
    "click": ["gcodesim/cli/*"],
    "rich": ["gcodesim/cli/*", "gcodesim/report/*"],
    "trimesh": ["gcodesim/machine/mesh.py"],
    "yaml": ["gcodesim/machine/yaml_lines.py"],
    "pydantic": ["gcodesim/machine/*"],
    "pydantic_core": ["gcodesim/machine/*"],
    "warp": ["gcodesim/collision/*", "gcodesim/stock/*", "gcodesim/study/kernels/*"],
    "matplotlib": ["gcodesim/report/study_plot.py"],
    "distributed": ["gcodesim/batch/cluster.py"],
    "numpy": ["gcodesim/*"],
}
"""Package -> the only files that may import it. What is not listed is imported nowhere."""

FILES_AND_SIGNALS = {"input_file", "output_file", "interrupt", "streams"}
"""How files are read and written, and what Ctrl-C does: the same for everybody."""

TYPES = FILES_AND_SIGNALS | {
    *("constants", "errors", "findings.codes", "findings.fingerprints", "findings.meanings"),
    *("checking.options", "checking.verdict", "nc.program", "nc.control.readings"),
    *("checking.option_kinds", "checking.request", "findings.left_out", "findings.printing"),
    "machine.model",
}
OUTWARD = TYPES - {"nc.program", "nc.control.readings", "machine.model"}
"""What those see who look at the outcome alone."""

STAGES = TYPES - {
    *("checking.options", "checking.option_kinds", "checking.request", "checking.verdict")
}
"""What the stages of a check see: they know nothing of what was asked, nor of verdicts."""

LAYERS = {
    "findings.explain": TYPES,
    "nc": STAGES - {"machine.model"},
    "machine": STAGES | {"nc"},
    "motion": STAGES | {"machine"},
    "collision": STAGES | {"machine", "motion"},
    "stock": STAGES | {"machine", "motion", "collision"},
    "checking.replay": TYPES | {"machine", "motion"},
    "checking.stocks": TYPES | {"machine", "motion", "collision", "stock"},
    "checking.trace": TYPES | {"machine", "motion"},
    "checking.variation": TYPES,
    "checking.evidence": TYPES | {"nc", "machine", "motion", "collision"},
    "checking.open_offsets": TYPES | {"nc"},
    "checking.audit": TYPES | {"collision"},
    "checking.lint": TYPES | {"machine", "motion", "collision"},
    "checking.flow": TYPES | {"nc", "machine", "motion", "collision", "checking"},
    "report": OUTWARD
    | {"findings.explain", "__init__", "checking.replay"}
    | {"collision.views.rays", "collision.views.distances"},
    "policy": OUTWARD | {"checking.variation"},
    "api": TYPES | {"nc", "machine", "checking.flow", "policy"},
    "batch": TYPES
    | {"nc", "machine", "collision", "checking.flow", "policy", "report", "__init__"},
    "starter": {"errors", "machine", "output_file", "__init__"},
    "study": TYPES | {"nc", "machine", "motion", "collision", "checking", "__init__"},
    "cli": TYPES
    | {"nc", "machine", "motion", "report", "policy", "study", "batch", "starter", "checking"}
    | {"findings.explain", "__init__"},
    "memory_limit": set(),
    "__main__": {"cli", "checking.verdict", "interrupt", "memory_limit", "streams"},
    "__init__": set(),
}
"""Layer -> what it may import besides itself; the types import only types."""

SHARED = {
    "Array": "NDArray[np.float64]",
    "Floats": "NDArray[np.float64]",
    "Ints": "NDArray[np.int64]",
    "Times": "NDArray[np.int64]",
    "Bools": "NDArray[np.bool_]",
}
"""Short names of arrays, which many modules give: each means the same wherever it stands."""

GENERICS = {
    *("tuple", "list", "dict", "set", "frozenset", "type", "Literal", "Annotated", "Callable"),
    *("Iterable", "Iterator", "Mapping", "Sequence", "NDArray"),
}
"""What types are put together with."""

ROOMS = {
    "nc": [*(("lines", "program"), "recorder", "control", "detect", "iso", ("canon", "interpret"))],
    "collision": [
        *(
            "geometry",
            "bodies",
            "bounds",
            "instants",
            ("baseline", "search"),
            "views",
            "forbidden",
            "detector",
        )
    ],
}
"""Folder -> its rooms in the order of their floors; imports lead downward only."""


@cache
def tree(file: str) -> ast.Module:
    return ast.parse((ROOT / file).read_text(encoding="utf-8"))


def functions(file: str) -> Iterator[ast.FunctionDef]:
    return (node for node in ast.walk(tree(file)) if isinstance(node, ast.FunctionDef))


def decorators(function: ast.FunctionDef) -> str:
    return " ".join(ast.unparse(decorator) for decorator in function.decorator_list)


def is_kernel_file(file: str) -> bool:
    return any("wp.kernel" in decorators(f) or "wp.func" in decorators(f) for f in functions(file))


def imports(file: str, *, late: bool, types: bool = False) -> Iterator[str]:
    """Names of the imported modules; `late`: in functions too, `types`: for types alone too."""
    pending: list[ast.AST] = list(tree(file).body)
    while pending:
        node = pending.pop()
        if not types and isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test):
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


def layer_names(file: str) -> list[str]:
    """Names by which LAYERS and TYPES may call a file, the longest first: nc.program, nc."""
    parts = file.removeprefix("gcodesim/").removesuffix(".py").removesuffix("/__init__").split("/")
    return [".".join(parts[:n]) for n in range(len(parts), 0, -1)]


@pytest.mark.parametrize("file", FILES)
def test_third_party_packages_stay_behind_their_walls(file: str) -> None:
    packages = {name.partition(".")[0] for name in imports(file, late=True)}
    for package in packages - set(sys.stdlib_module_names) - {"gcodesim"}:
        allowed = THIRD_PARTY.get(package, [])
        assert any(fnmatch(file, pattern) for pattern in allowed), f"{package} in {file}"


@pytest.mark.parametrize("file", FILES)
def test_nothing_is_imported_upward(file: str) -> None:
    names = layer_names(file)
    if file.endswith("__init__.py") and not [*imports(file, late=True)]:
        return
    own = next((name for name in names if name in TYPES or name in LAYERS), "")
    assert own, f"{file} belongs to no layer"
    allowed = TYPES if own in TYPES else {own, *LAYERS[own]}
    for module in imports(file, late=True):
        if target := module_file(module):
            assert {*layer_names(target)} & allowed, f"{file} imports {target}"


@pytest.mark.parametrize("folder", ROOMS)
def test_rooms_import_only_what_stands_below_them(folder: str) -> None:
    floors = {
        room: floor
        for floor, rooms in enumerate(ROOMS[folder])
        for room in ([rooms] if isinstance(rooms, str) else rooms)
    }
    prefix = f"gcodesim/{folder}/"
    for file in FILES:
        room = file.removeprefix(prefix).removesuffix(".py").partition("/")[0]
        if not file.startswith(prefix) or room == "__init__":
            continue
        for module in imports(file, late=True, types=True):
            target = module.split(".")[2:3]
            if module.startswith(f"gcodesim.{folder}.") and target != [room]:
                assert floors[target[0]] < floors[room], f"{file} imports {module}"


def test_no_import_circles_between_files_nor_between_rooms() -> None:
    """Late imports, and those for types alone, count."""
    for what, row in structure(ROOT).items():
        assert not row.get("in circles"), what


def test_the_tree_of_errors_names_each_of_them() -> None:
    named = set(re.findall(r"\w+Error", ast.get_docstring(tree("gcodesim/errors.py")) or ""))
    bases: dict[str, set[str]] = {}
    for file in FILES:
        for node in tree(file).body:
            if isinstance(node, ast.ClassDef):
                bases[node.name] = {ast.unparse(base) for base in node.bases}
    ours = {"GcodesimError"}
    while more := {name for name, above in bases.items() if above & ours} - ours:
        ours |= more
    assert named == ours


def test_no_class_name_and_no_module_name_stands_twice() -> None:
    """Names of types that are put together from others count, too."""
    classes: dict[str, list[str]] = {}
    modules: dict[str, list[str]] = {}
    for file in FILES:
        stem = file.removesuffix(".py").rpartition("/")[2]
        if not stem.startswith("__"):
            modules.setdefault(stem, []).append(file)
        for node in tree(file).body:
            for name in type_names(node):
                if not name.startswith("_"):
                    classes.setdefault(name, []).append(file)
    assert [name for name, files in classes.items() if len(files) > 1] == []
    assert [name for name, files in modules.items() if len(files) > 1] == []


def type_names(node: ast.stmt) -> list[str]:
    """Names of types that a statement at the top of a module gives, but for those of SHARED."""
    if isinstance(node, ast.ClassDef):
        return [node.name]
    if not isinstance(node, ast.Assign | ast.AnnAssign) or not node.value:
        return []
    if isinstance(node.value, ast.Constant) or not is_type_expression(node.value):
        return []
    text = ast.unparse(node.value)
    return [name for name in defined(node) if SHARED.get(name) != text]


def is_type_expression(value: ast.expr) -> bool:
    """Tell whether a value is a type: `dict[str, int]`, `A | None`, `TypeVar("T")`."""
    if isinstance(value, ast.BinOp) and isinstance(value.op, ast.BitOr):
        return is_type_expression(value.left) or is_type_expression(value.right)
    if isinstance(value, ast.Constant):
        return value.value is None
    if isinstance(value, ast.Call):
        return ast.unparse(value.func) == "TypeVar"
    return isinstance(value, ast.Subscript) and ast.unparse(value.value) in GENERICS


def test_study_ships_nothing_that_its_commands_do_not_use() -> None:
    """What only tests use stands with them."""
    inside = [file for file in FILES if file.startswith("gcodesim/study/")]
    bodies: dict[str, list[ast.stmt]] = {}
    for file in inside:
        for node in tree(file).body:
            for name in defined(node):
                bodies.setdefault(name, []).append(node)
    outside = (node for file in FILES if file not in inside for node in ast.walk(tree(file)))
    pending = {
        alias.name
        for node in outside
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("gcodesim.study")
        for alias in node.names
    }
    reached: set[str] = set()
    while pending:
        name = pending.pop()
        reached.add(name)
        used = {n for body in bodies.get(name, []) for node in ast.walk(body) for n in names(node)}
        pending |= (used & bodies.keys()) - reached
    assert sorted(bodies.keys() - reached) == []


def defined(node: ast.stmt) -> list[str]:
    """Names that a statement at the top of a module gives."""
    if isinstance(node, ast.FunctionDef | ast.ClassDef):
        return [node.name]
    if isinstance(node, ast.Assign | ast.AnnAssign):
        targets = node.targets if isinstance(node, ast.Assign) else [node.target]
        return [n.id for t in targets for n in ast.walk(t) if isinstance(n, ast.Name)]
    return []


def names(node: ast.AST) -> list[str]:
    """Names that are used at a node."""
    return [getattr(node, field) for field in ("id", "attr") if hasattr(node, field)]


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


def test_functions_stay_short() -> None:
    long = [
        f"{file}: {function.name}"
        for file in FILES
        for function in functions(file)
        if (function.end_lineno or 0) - function.lineno >= 60
    ]
    assert long == []


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


@pytest.mark.parametrize("file", ["gcodesim/findings/codes.py", "gcodesim/findings/meanings.py"])
def test_no_code_or_meaning_is_given_twice(file: str) -> None:
    for node in ast.walk(tree(file)):
        if isinstance(node, ast.Dict):
            keys = [ast.unparse(key) for key in node.keys if key]
            assert len(keys) == len(set(keys))


def test_every_meaning_has_a_code_of_the_table() -> None:
    assert {code for code, _ in MEANINGS.values()} <= CODES.keys()


@pytest.mark.parametrize("file", [file for file in FILES if file.startswith("gcodesim/nc/")])
def test_code_asks_a_reading_and_never_the_name_of_a_dialect(file: str) -> None:
    for node in ast.walk(tree(file)):
        parts = [node.left, *node.comparators] if isinstance(node, ast.Compare) else []
        names = {leaf.value for part in parts for leaf in ast.walk(part) if is_text(leaf)}
        assert not names & ROWS.keys(), f"{file}:{node.lineno}"


def is_text(node: ast.AST) -> TypeGuard[ast.Constant]:
    return isinstance(node, ast.Constant) and isinstance(node.value, str)
