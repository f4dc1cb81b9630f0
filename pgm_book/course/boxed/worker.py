"""What runs in the box, with a student's code: it shares nothing with the judge.

It reads one request a line from the standard input, and writes one answer a line to
what was the standard output. All that leaves it is plain data, and whoever reads it
takes every word for a stranger's.

    python -I -S worker.py FOLDER ... (for sys.path)
"""

import builtins
import importlib
import json
import os
import sys
import types
from collections.abc import Callable
from typing import Any

MEMORY = 2 * 2**30  # bytes that a process may ask for
FILE = 16 * 2**20  # bytes of a file that it may write
SECONDS = 120  # of computing
BYTES = 8 * 2**20  # of an answer


def limited() -> None:
    """Set what the process may use; what it starts inherits that."""
    try:
        import resource
    except ImportError:  # Windows
        return
    for what, most in (
        (resource.RLIMIT_AS, MEMORY),
        (resource.RLIMIT_FSIZE, FILE),
        (resource.RLIMIT_CPU, SECONDS),
        (resource.RLIMIT_NOFILE, 64),
        (resource.RLIMIT_CORE, 0),
    ):
        resource.setrlimit(what, (most, most))


class Worker:
    """The student's names, and the lines that go out and in."""

    def __init__(self, lines_in: Any, lines_out: Any) -> None:
        self.lines_in, self.lines_out = lines_in, lines_out
        self.names: dict[str, Any] = {}

    def serve(self) -> None:
        """Answer requests until there are no more."""
        process = os.getpid()
        for line in self.lines_in:
            request = json.loads(line)
            answer = self.guarded(getattr(self, request["do"]), request)
            if os.getpid() != process:  # a copy that the student's code made
                os._exit(1)
            self.write(answer)

    def write(self, answer: dict) -> None:
        """Write one line."""
        text = json.dumps(answer)
        if len(text) > BYTES:
            text = json.dumps({"error": ["TooMuch", "the answer is too large", ""]})
        self.lines_out.write(text.encode() + b"\n")
        self.lines_out.flush()

    def guarded(self, do: Callable[[dict], Any], request: dict) -> dict:
        """Return what a request gives, or what kind of error it ends in."""
        try:
            return {"value": do(request)}
        except BaseException as error:  # sys.exit, too
            return {"error": described(error)}

    def load(self, request: dict) -> list:
        """Run cells in their order; return the errors by the cell's place."""
        for name, content in request["files"].items():
            os.makedirs(os.path.dirname(name) or ".", exist_ok=True)
            with open(name, "wb") as file:
                file.write(bytes.fromhex(content))
        module = types.ModuleType("__main__")
        sys.modules["__main__"], self.names = module, vars(module)
        errors = []
        for k, cell in enumerate(request["cells"]):
            try:
                exec(compile(cell, f"cell {k + 1}", "exec"), self.names)
            except BaseException as error:
                errors.append([k, *described(error)])
        return errors

    def kind(self, request: dict) -> str:
        """Say whether a name is a function, a value or missing."""
        if request["name"] not in self.names:
            return "missing"
        return "function" if callable(self.names[request["name"]]) else "value"

    def value(self, request: dict) -> Any:
        """Return the value of a name."""
        return plain.packed(self.names[request["name"]])

    def call(self, request: dict) -> dict:
        """Call a function of the student's; return its answer and changed arguments."""
        arguments = plain.unpacked(request["arguments"], self.distant)
        named = plain.unpacked(request["named"], self.distant)
        before = [plain.packed(a, id) for a in arguments]
        answer = self.names[request["name"]](*arguments, **named)
        changed = {
            k: plain.packed(argument)
            for k, argument in enumerate(arguments)
            if isinstance(argument, np.ndarray) and plain.packed(argument) != before[k]
        }
        return {"answer": plain.packed(answer), "changed": changed}

    def handed(self, request: dict) -> list:
        """Return what was handed in as the result of the task, last."""
        task = importlib.import_module("pgm_book.task")
        return [plain.packed(one) for one in task.HANDED[-1:]]

    def distant(self, number: int) -> Callable:
        """Return a function of the judge's, which is called by its number."""

        def function(*arguments: Any) -> Any:
            self.write({"call": number, "arguments": plain.packed(list(arguments))})
            answer = json.loads(next(self.lines_in))
            if "error" in answer:
                raise ValueError(answer["error"])
            return plain.unpacked(answer["value"])

        return function


def described(error: BaseException) -> list[str]:
    """An error by its class, what it says, and the name that a NameError misses."""
    kind = next(
        (one.__name__ for one in type(error).__mro__ if known(one)), "BaseException"
    )
    try:
        said = str(error)[:500]
    except BaseException:  # of a class of the student's own
        said = ""
    missing = getattr(error, "name", "") if isinstance(error, NameError) else ""
    return [kind, said, str(missing or "")[:80]]


def known(kind: type) -> bool:
    """Whether an error's class is one of Python, NumPy or this box."""
    name = kind.__name__
    mine = kind.__module__ == "nothing" or name == "LinAlgError"
    return mine or getattr(builtins, name, None) is kind


if __name__ == "__main__":
    # The channel is kept; what the student prints goes nowhere.
    channel = os.fdopen(os.dup(1), "wb")
    nowhere = os.open(os.devnull, os.O_RDWR)
    requests = os.fdopen(os.dup(0), "rb")
    for standard in (0, 1, 2):
        os.dup2(nowhere, standard)
    limited()
    here = os.path.dirname(os.path.abspath(__file__))
    sys.path[:0] = sys.argv[1:]
    sys.path.insert(0, here)
    import nothing  # type: ignore[import-not-found]
    import numpy as np
    import plain  # type: ignore[import-not-found]

    sys.path.remove(here)
    sys.meta_path.insert(0, nothing.Finder())
    Worker(requests, channel).serve()
