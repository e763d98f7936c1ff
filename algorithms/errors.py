"""The error tree of the mathematics.

* FilterRoomError                      message, code, remedy
  + InputError                         the user's data or parameters (HTTP 422, or a rejected row)
    x ParameterError                   a parameter of an algorithm or a scenario; `pointer` names the field
    x RecordingError                   a recording that cannot serve: kind, site, truth; `pointer` names the field
    x MarkFormatError                  one line of a file; `line` and `column` name the place
    x UnsupportedFormatError           a file in no format we read
    x FrameError                       a coordinate outside the domain of a conversion
  + AlgorithmError                     the method could not go on (failed run)
    x SingularGeometryError            stations from which nothing can be solved
    x NotPositiveDefiniteError         a covariance that lost its meaning
  + CompilationError                   the kernels cannot be compiled, or loaded, on this machine
* RunCancelled(BaseException)          control flow inside a run only
"""

from __future__ import annotations

__all__ = [
    "AlgorithmError",
    "CompilationError",
    "FilterRoomError",
    "FrameError",
    "InputError",
    "MarkFormatError",
    "NotPositiveDefiniteError",
    "ParameterError",
    "RecordingError",
    "RunCancelled",
    "SingularGeometryError",
    "UnsupportedFormatError",
]


class FilterRoomError(Exception):
    """Base of everything this program raises on purpose: what happened, a stable code, what to do."""

    code = "error"

    def __init__(self, message: str, *, remedy: str = "", code: str | None = None) -> None:
        super().__init__(message)
        self.message = message
        self.remedy = remedy
        if code is not None:
            self.code = code

    def __str__(self) -> str:
        """Message and remedy as one text."""
        return f"{self.message} {self.remedy}".strip()


class InputError(FilterRoomError):
    """The user's data or parameters cannot be used; `pointer` is a JSON pointer to the field."""

    code = "input"

    def __init__(self, message: str, *, pointer: str = "", remedy: str = "", code: str | None = None) -> None:
        super().__init__(message, remedy=remedy, code=code)
        self.pointer = pointer


class ParameterError(InputError):
    """A parameter is outside what the method can work with."""

    code = "parameter"


class RecordingError(InputError):
    """The recording lacks something that the algorithm needs, or is of another kind."""

    code = "recording"


class MarkFormatError(InputError):
    """One line of a file does not say what it must."""

    code = "mark_format"

    def __init__(self, message: str, *, line: int, column: str = "", remedy: str = "", code: str | None = None) -> None:
        super().__init__(message, pointer=f"/line/{line}" + (f"/{column}" if column else ""), remedy=remedy, code=code)
        self.line = line
        self.column = column


class UnsupportedFormatError(InputError):
    """The content is in no format that a reader recognises."""

    code = "unsupported_format"


class FrameError(InputError):
    """A coordinate lies outside the domain of a conversion."""

    code = "frame"


class AlgorithmError(FilterRoomError):
    """The method could not go on at `time_s` of `track`."""

    code = "algorithm"

    def __init__(
        self,
        message: str,
        *,
        time_s: float | None = None,
        track: int | None = None,
        remedy: str = "",
        code: str | None = None,
    ) -> None:
        super().__init__(message, remedy=remedy, code=code)
        self.time_s = time_s
        self.track = track


class SingularGeometryError(AlgorithmError):
    """The stations lie so that nothing can be solved from them."""

    code = "singular_geometry"


class NotPositiveDefiniteError(AlgorithmError):
    """A covariance lost its positive definiteness beyond repair."""

    code = "not_positive_definite"


class CompilationError(FilterRoomError):
    """The kernels cannot be compiled or loaded; notes hold all that the compiler said."""

    code = "kernels_not_compiled"


class RunCancelled(BaseException):
    """The user cancelled the run; raised between slices of work, caught by the worker's entry point."""
