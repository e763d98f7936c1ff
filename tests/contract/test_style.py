"""Rules of the house that no linter knows."""

from __future__ import annotations

import ast
import re
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parents[2]
SOURCES = sorted([*ROOT.glob("algorithms/**/*.py"), *ROOT.glob("backend/**/*.py")])
# A name that says nothing attracts everything.
EMPTY_NAMES = re.compile(r"(^|_)(utils?|helpers?|managers?|misc|common)(_|$)")
KERNEL = {"bare", "woven", "kernel", "inlined", "strict"}


@cache
def nodes(path: Path) -> list[ast.AST]:
    return [
        node
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.FunctionDef | ast.ClassDef | ast.ExceptHandler)
    ]


def functions(path: Path) -> list[ast.FunctionDef]:
    return [node for node in nodes(path) if isinstance(node, ast.FunctionDef)]


def is_kernel(function: ast.FunctionDef) -> bool:
    return any(isinstance(d, ast.Name) and d.id in KERNEL for d in function.decorator_list)


def is_annotated(function: ast.FunctionDef) -> bool:
    arguments = [*function.args.posonlyargs, *function.args.args, *function.args.kwonlyargs]
    named = [a for a in arguments if a.arg not in ("self", "cls")]
    return function.returns is not None and all(a.annotation is not None for a in named)


def test_only_kernels_do_without_annotations() -> None:
    bare = [
        f"{path.relative_to(ROOT)}:{f.lineno} {f.name}"
        for path in SOURCES
        for f in functions(path)
        if not is_annotated(f) and not is_kernel(f)
    ]
    assert not bare


def test_some_functions_are_kernels() -> None:
    """Otherwise the rule above would hold because nothing is recognised."""
    assert sum(is_kernel(f) for path in SOURCES for f in functions(path)) > 20


def test_no_name_says_nothing() -> None:
    files = [p for p in [*SOURCES, *ROOT.glob("frontend/**/*.js")] if EMPTY_NAMES.search(p.stem)]
    classes = [
        f"{path.relative_to(ROOT)} {node.name}"
        for path in SOURCES
        for node in nodes(path)
        if isinstance(node, ast.ClassDef) and re.search(r"(Utils?|Helper|Manager)$", node.name)
    ]
    assert not files
    assert not classes


def swallows(handler: ast.ExceptHandler) -> bool:
    catches_all = handler.type is None or (
        isinstance(handler.type, ast.Name) and handler.type.id in ("Exception", "BaseException")
    )
    return catches_all and all(isinstance(statement, ast.Pass | ast.Continue) for statement in handler.body)


def test_errors_are_not_swallowed() -> None:
    silent = [
        f"{path.relative_to(ROOT)}:{node.lineno}"
        for path in SOURCES
        for node in nodes(path)
        if isinstance(node, ast.ExceptHandler) and swallows(node)
    ]
    assert not silent
