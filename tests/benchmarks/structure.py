"""The structure of the package in figures: rooms, arrows, floors, circles, functions, names.

A room is a file or a folder of the level that is looked at, an arrow one or more imports from a
room to another (late imports, and those for types alone, count). A room stands one floor above the
highest that it imports; rooms that import each other are a circle. Run from the repository root:
python tests/benchmarks/structure.py [--root DIR] [--out FILE]; --root may be another checkout.
"""

from __future__ import annotations

import argparse
import ast
import json
import statistics
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = "gcodesim"


def main() -> int:
    """Print the figures, and write them where --out says."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--root", type=Path, default=ROOT, help="repository to look at")
    parser.add_argument("--out", type=Path, help="JSON file to write")
    given = parser.parse_args()
    figures = structure(given.root)
    for name, row in figures.items():
        print(f"{name:28}", "  ".join(f"{key} {value}" for key, value in row.items()))
    if given.out:
        given.out.write_text(json.dumps(figures, indent=1) + "\n", encoding="utf-8")
    return 0


def structure(root: Path) -> dict[str, dict[str, Any]]:
    """Return the figures of a repository, by what they are about."""
    files = {module_of(path, root): path for path in sorted(root.glob(f"{PACKAGE}/**/*.py"))}
    trees = {name: ast.parse(path.read_text("utf-8")) for name, path in files.items()}
    arrows = {name: set(imports(trees[name], trees.keys())) - {name} for name in trees}
    figures = {"files": _circles(arrows), PACKAGE: level(arrows, PACKAGE)}
    folders = {name.rpartition(".")[0] for name in files} - {PACKAGE, ""}
    for folder in sorted(folders):
        figures[folder] = level(arrows, folder)
    stems = [path.stem for path in files.values() if path.stem != "__init__"]
    return figures | {"names": _names(trees, stems), "functions": _functions(trees)}


def module_of(path: Path, root: Path) -> str:
    """Return the name of the module in a file."""
    parts = path.relative_to(root).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def imports(tree: ast.Module, known: Any) -> Iterator[str]:
    """Yield the modules of ours that a module imports, wherever in it."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names if alias.name in known)
        elif isinstance(node, ast.ImportFrom) and node.module in known:
            below = [f"{node.module}.{alias.name}" for alias in node.names]
            inner = [name for name in below if name in known]
            yield from inner
            if len(inner) < len(below):
                yield str(node.module)


def level(arrows: dict[str, set[str]], folder: str) -> dict[str, Any]:
    """Return rooms, arrows, floors and circles of a folder, seen from outside its own folders."""

    def room(module: str) -> str:
        return module.removeprefix(f"{folder}.").split(".")[0] if module != folder else ""

    inside = [name for name in arrows if name.startswith(f"{folder}.")]
    graph: dict[str, set[str]] = {room(name): set() for name in inside}
    for name in inside:
        for target in arrows[name]:
            if target.startswith(f"{folder}.") and room(target) != room(name):
                graph[room(name)].add(room(target))
    rows = {"rooms": len(graph), "arrows": sum(map(len, graph.values()))}
    return {**rows, "floors": _floors(graph), **_circles(graph)}


def _floors(graph: dict[str, set[str]]) -> int:
    """Return the number of floors; rooms in a circle, or above one, stand on the top floor."""
    left, floors = dict(graph), 0
    while left:
        ground = {room for room, needed in left.items() if not needed & left.keys()}
        floors += 1
        left = {room: needed for room, needed in left.items() if room not in ground}
        if not ground:
            break
    return floors


def _circles(graph: dict[str, set[str]]) -> dict[str, int]:
    """Return how many rooms stand in circles."""
    left = {room: needed & graph.keys() for room, needed in graph.items()}
    while True:
        inner = {room for room in left if left[room] & left.keys()}
        inner &= {target for needed in left.values() for target in needed}
        if inner == left.keys():
            return {"in circles": len(inner)}
        left = {room: left[room] & inner for room in inner}


def _names(trees: dict[str, ast.Module], stems: list[str]) -> dict[str, int]:
    """Return how many modules, and public classes, share their name with another."""
    classes = Counter(
        node.name for tree in trees.values() for node in tree.body if isinstance(node, ast.ClassDef)
    )
    return {
        "modules": len(trees),
        "module names twice": sum(count > 1 for count in Counter(stems).values()),
        "classes": len(classes),
        "class names twice": sum(n > 1 for name, n in classes.items() if name[0] != "_"),
    }


def _functions(trees: dict[str, ast.Module]) -> dict[str, Any]:
    """Return the number of functions, and how long they are in lines."""
    lengths = {
        f"{name}.{node.name}": (node.end_lineno or 0) - node.lineno + 1
        for name, tree in trees.items()
        for node in ast.walk(tree)
        if isinstance(node, ast.FunctionDef)
    }
    ranks = statistics.quantiles(lengths.values(), n=100)
    longest = max(lengths, key=lambda name: lengths[name])
    return {
        "count": len(lengths),
        "median": statistics.median(lengths.values()),
        "p90": round(ranks[89]),
        "p99": round(ranks[98]),
        "max": lengths[longest],
        "longest": longest,
        "over 40": sum(length > 40 for length in lengths.values()),
    }


if __name__ == "__main__":
    raise SystemExit(main())
