"""Receive an upload straight into files of the data folder, in one pass.

The framework's own form parsing spools every part to the system's temporary folder first, where a full disk looks
like a malformed request; here a part is written once, next to the store that will keep it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, TYPE_CHECKING

from fastapi import Request
from python_multipart.exceptions import MultipartParseError
from python_multipart.multipart import MultipartParser, parse_options_header

from backend.http.problems import ProblemError

if TYPE_CHECKING:
    from python_multipart.multipart import MultipartCallbacks

# A form of this program has a handful of parts; thousands are an attack.
MAX_PARTS = 200


@dataclass
class Part:
    """One part of a form, or a raw body: its field's name, the client's file name (a label only), its bytes."""

    name: str
    file_name: str
    path: Path
    size: int = 0


@dataclass
class Parts:
    """The parts that were received; those that nobody took are deleted by `received`."""

    items: list[Part] = field(default_factory=list)

    def named(self, name: str) -> list[Part]:
        """Return the parts of one field."""
        return [p for p in self.items if p.name == name]


class _Receiver:
    """Writes what the parser finds; the parser calls `on_*`."""

    def __init__(self, parts: Parts, temporary: Callable[[], Path]) -> None:
        self._parts = parts
        self._temporary = temporary
        self._out: IO[bytes] | None = None
        self._header_name = b""
        self._header_value = b""
        self._headers: dict[bytes, bytes] = {}

    def callbacks(self) -> MultipartCallbacks:
        return {
            "on_part_begin": self.on_part_begin,
            "on_header_field": self.on_header_field,
            "on_header_value": self.on_header_value,
            "on_header_end": self.on_header_end,
            "on_headers_finished": self.on_headers_finished,
            "on_part_data": self.on_part_data,
            "on_part_end": self.on_part_end,
        }

    def on_part_begin(self) -> None:
        self._headers = {}

    def on_header_field(self, data: bytes, start: int, end: int) -> None:
        self._header_name += data[start:end]

    def on_header_value(self, data: bytes, start: int, end: int) -> None:
        self._header_value += data[start:end]

    def on_header_end(self) -> None:
        self._headers[self._header_name.lower()] = self._header_value
        self._header_name = self._header_value = b""

    def on_headers_finished(self) -> None:
        if len(self._parts.items) >= MAX_PARTS:
            raise malformed(f"The form has more than {MAX_PARTS} parts.")
        _, options = parse_options_header(self._headers.get(b"content-disposition", b""))
        name = options.get(b"name", b"").decode("utf-8", "replace")
        if not name:
            raise malformed("A part of the form has no name.")
        file_name = options.get(b"filename", b"").decode("utf-8", "replace")
        part = Part(name, label_of(file_name), self._temporary())
        self._parts.items.append(part)
        self._out = part.path.open("xb")

    def on_part_data(self, data: bytes, start: int, end: int) -> None:
        assert self._out is not None
        self._out.write(data[start:end])
        self._parts.items[-1].size += end - start

    def on_part_end(self) -> None:
        self.close()

    def close(self) -> None:
        if self._out is not None:
            self._out.close()
            self._out = None


def malformed(detail: str) -> ProblemError:
    """Return the error of a body that cannot be taken apart."""
    return ProblemError(400, "malformed_request", detail)


def label_of(file_name: str) -> str:
    """Return the last part of a client's path without control characters: a label, never a path of ours."""
    base = file_name.replace("\\", "/").rsplit("/", 1)[-1]
    return "".join(c for c in base if c.isprintable())[:200]


@contextmanager
def received() -> Iterator[Parts]:
    """Give a list for the parts and delete the files that are still there at the end."""
    parts = Parts()
    try:
        yield parts
    finally:
        for part in parts.items:
            part.path.unlink(missing_ok=True)


async def receive_form(request: Request, parts: Parts, temporary: Callable[[], Path]) -> None:
    """Read a multipart body into `parts`."""
    _, options = parse_options_header(request.headers.get("content-type", ""))
    boundary = options.get(b"boundary", b"")
    if not boundary:
        raise malformed("The Content-Type of the form names no boundary.")
    receiver = _Receiver(parts, temporary)
    ended = False

    def on_end() -> None:
        nonlocal ended
        ended = True

    try:
        parser = MultipartParser(boundary, {**receiver.callbacks(), "on_end": on_end})
        async for chunk in request.stream():
            parser.write(chunk)
        parser.finalize()
    except MultipartParseError as error:
        raise malformed(f"The form cannot be taken apart: {error}.") from error
    finally:
        receiver.close()
    if not ended:
        raise malformed("The form ends in the middle; send it again.")


async def receive_raw(request: Request, parts: Parts, temporary: Callable[[], Path], file_name: str) -> None:
    """Read a raw body into one part named `file`."""
    part = Part("file", label_of(file_name), temporary())
    parts.items.append(part)
    with part.path.open("xb") as out:
        async for chunk in request.stream():
            out.write(chunk)
            part.size += len(chunk)
