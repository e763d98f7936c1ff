"""What a compiler said becomes one sentence; all of it stays in a note, also on the way from a worker."""

from __future__ import annotations

import pickle

from algorithms.warm_up import compilation_error

SAID = """Traceback (most recent call last):
  File "<string>", line 1, in <module>
  File "algorithms/forward_scatter/lines.py", line 39, in weighted_line
numba.core.errors.TypingError: Failed in nopython mode pipeline (step: nopython frontend)
No implementation of function Function(<built-in function add>) found for signature:
During: typing of intrinsic-call at lines.py (39)"""


def test_the_first_line_of_the_error_is_told() -> None:
    error = pickle.loads(pickle.dumps(compilation_error("forward_scatter", SAID)))
    assert error.message == (
        "The kernels of forward_scatter cannot be compiled: "
        "numba.core.errors.TypingError: Failed in nopython mode pipeline (step: nopython frontend)."
    )
    assert "restart the server" in error.remedy
    assert error.__notes__ == [SAID]


def test_a_process_that_was_killed_said_nothing_of_an_error() -> None:
    assert compilation_error("rdf", "status -9").message == "The kernels of rdf cannot be compiled: status -9."
