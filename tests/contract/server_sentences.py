"""Every sentence that the sources say to a person, as a template: what is filled in stands as {1}, {2}, ..."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

# What is called with a sentence that the page shows.
SPEAKERS = {
    "AlgorithmError",
    "FrameError",
    "InputError",
    "MarkFormatError",
    "NotFoundError",
    "NotPositiveDefiniteError",
    "Note",
    "ParameterError",
    "Problem",
    "ProblemError",
    "ProblemItem",
    "QuotaError",
    "RecordingError",
    "SingularGeometryError",
    "StateError",
    "StorageError",
    "TooLargeError",
    "UnavailableError",
    "UnsupportedFormatError",
    "ValueError",
    "Verdict",
    "_bad_cursor",
    "_fail",
    "_failure",
    "_item",
    "_locked",
    "append_log",
    "malformed",
    "problem_response",
    "reject",
    "warn",
}
# Names that hold a sentence, or a piece of one.
NAMES = {"detail", "remedy", "message", "limits", "named", "count"}
# Said in a terminal before there is a page, or to a programmer.
SILENT = (
    "backend/backup.py",
    "backend/cli/",
    "backend/settings.py",
    "backend/db/migrate.py",
    "backend/db/snapshot.py",
    "backend/db/tables.py",
    "backend/files/lock.py",
    "backend/files/array_file.py:ValueError",
    "backend/files/store.py:ValueError",
    "algorithms/registry.py",
)


def _template(node: ast.expr) -> str | None:
    """The text of a literal, with a place for each value that is filled in."""
    match node:
        case ast.Constant(value=str(text)):
            return text
        case ast.JoinedStr(values=parts):
            return "".join(str(p.value) if isinstance(p, ast.Constant) else "{}" for p in parts)
        case _:
            return None


def _branches(node: ast.expr) -> Iterator[ast.expr]:
    """What an argument may be: both sides of a condition, and what stands after an `or`."""
    if isinstance(node, ast.IfExp):
        yield from _branches(node.body)
        yield from _branches(node.orelse)
    elif isinstance(node, ast.BoolOp):
        for value in node.values:
            yield from _branches(value)
    else:
        yield node


def _numbered(template: str) -> str:
    first, *rest = template.split("{}")
    return first + "".join(f"{{{i}}}{part}" for i, part in enumerate(rest, start=1))


def _arguments(node: ast.AST, name: str) -> Iterator[ast.expr]:
    """What a node says to a person: arguments of a speaker, or a value that is called as sentences are called."""
    if isinstance(node, ast.Call):
        speaker = node.func.id if isinstance(node.func, ast.Name) else getattr(node.func, "attr", "")
        if speaker in SPEAKERS and f"{name}:{speaker}" not in SILENT:
            yield from (*node.args, *(k.value for k in node.keywords))
    elif isinstance(node, ast.Dict):
        for key, value in zip(node.keys, node.values, strict=True):
            if isinstance(key, ast.Constant) and key.value in NAMES:
                yield value
    elif isinstance(node, ast.Assign | ast.AnnAssign) and node.value is not None:
        targets = node.targets if isinstance(node, ast.Assign) else [node.target]
        names = [t.elts if isinstance(t, ast.Tuple) else [t] for t in targets]
        values = node.value.elts if isinstance(node.value, ast.Tuple) else [node.value]
        if any(isinstance(t, ast.Name) and t.id in NAMES for some in names for t in some):
            yield from values


def said_in(path: Path, name: str) -> Iterator[str]:
    """The sentences of one source file: literals of more than one word."""
    for node in ast.walk(ast.parse(path.read_text("utf-8"))):
        for argument in _arguments(node, name):
            for branch in _branches(argument):
                text = _template(branch)
                if text is not None and " " in text.strip() and not text.isupper():
                    yield _numbered(" ".join(text.split()))


def sentences(root: Path) -> dict[str, str]:
    """Template to the file that says it."""
    found: dict[str, str] = {}
    for folder in ("algorithms", "backend"):
        for path in sorted((root / folder).rglob("*.py")):
            name = path.relative_to(root).as_posix()
            if not name.startswith(SILENT):
                for text in said_in(path, name):
                    found.setdefault(text, name)
    return found
