"""A box for a student's code: a process that holds nothing and may do nothing.

On Linux bubblewrap (``bwrap``) closes it: no network, no files but the system's and
the students' library, all of them read-only, an empty folder of its own, no second
process or thread. The judge asks through a pipe, with a limit of time, and reads plain
data.
Bubblewrap: https://github.com/containers/bubblewrap, version 0.8 or newer.
"""

import builtins
import contextlib
import itertools
import json
import os
import platform
import random
import shutil
import signal
import struct
import subprocess
import sys
import sysconfig
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from pgm_book.course.boxed import plain, worker
from pgm_book.course.boxed.nothing import BooksOwn

CLOSED = "it is closed"
LOADING, CALLING, WHOLE = 30.0, 10.0, 120.0  # seconds; of all calls of a box
CALLBACKS = 20_000  # calls of a function of the judge's, in all
ROOM = 64 * 2**20  # bytes of the box's own folder
HOME = "/home/student"
WINDOWS = {k: v for k, v in os.environ.items() if k == "SYSTEMROOT"}
VARIABLES = {
    "HOME": HOME,
    "TMPDIR": HOME,
    "LANG": "C.UTF-8",
    "PATH": "/usr/bin",
    **dict.fromkeys(
        "OMP_NUM_THREADS OPENBLAS_NUM_THREADS MKL_NUM_THREADS"
        " OPENCV_FOR_THREADS_NUM PYTHONUTF8".split(),
        "1",
    ),
}


# Numbers of system calls: how an architecture names itself to a filter, and what
# makes processes or threads on it, or memory that no limit counts.
# (Linux, include/uapi/linux/audit.h, arch/*/syscall.tbl)
MACHINES = {
    "x86_64": (
        0xC000003E,
        {"clone": 56, "clone3": 435, "fork": 57, "vfork": 58}
        | {"shmget": 29, "memfd_create": 319},
    ),
    "aarch64": (
        0xC00000B7,
        {"clone": 220, "clone3": 435, "shmget": 194, "memfd_create": 279},
    ),
}


BOOKS_OWN = "calls the book's own function"
NAMED = {  # what a student's code was refused, by the beginning of its error
    "BooksOwn": BOOKS_OWN,
    "MemoryError": f"asked for more than {worker.MEMORY / 2**30:.0f} GB of memory",
    "SystemExit": "ended the program",
    "PermissionError: [Errno 1]": "tried to start another process",
    "RuntimeError: can't start new thread": "tried to start a thread",
    "OSError: [Errno 101]": "tried to reach a network",
    "gaierror": "tried to reach a network",
    "OSError: [Errno 27]": f"wrote a file of more than {worker.FILE // 2**20} MB",
    "OSError: [Errno 28]": f"wrote more than {ROOM // 2**20} MB",
    "OSError: [Errno 30]": "tried to write outside its folder",
}
REFUSED = {*NAMED.values()} - {BOOKS_OWN}


def named(said: str) -> str:
    """Return an error in words, if it is one of what the box refuses."""
    found = (words for begin, words in NAMED.items() if said.startswith(begin))
    return next(found, said)


class NoAnswer(Exception):
    """The box gives no answer any more."""


def closed() -> str:
    """Return why no box can be closed on this machine; nothing if one can."""
    if shutil.which("bwrap") is None:
        return "bubblewrap is not installed (Debian, Ubuntu: apt install bubblewrap)"
    if platform.machine() not in MACHINES:
        return f"processes cannot be counted on {platform.machine()}"
    with tempfile.TemporaryDirectory() as empty, filtered() as number:
        command = [*wall(Path(empty), number), python(), "-I", "-S", "-c", "pass"]
        done = subprocess.run(
            command, capture_output=True, text=True, check=False, pass_fds=[number]
        )
    return f"bubblewrap does not start: {done.stderr[:300]}" if done.returncode else ""


@contextlib.contextmanager
def filtered() -> Iterator[int]:
    """Give a file with a filter of system calls, by which the refused ones fail.

    A limit of processes would not do, since root has none. Classic BPF, see seccomp(2).
    """
    architecture, calls = MACHINES[platform.machine()]
    LOAD, EQUAL, ANY, RETURN = 0x20, 0x15, 0x45, 0x06
    ALLOW, KILL, NOT_PERMITTED = 0x7FFF0000, 0x80000000, 0x00050001
    steps = [
        (LOAD, 0, 0, 4),  # the architecture
        (EQUAL, 1, 0, architecture),
        (RETURN, 0, 0, KILL),
        (LOAD, 0, 0, 0),  # the number of the call
        (ANY, 0, 1, 0x40000000),  # another set of numbers, x32
        (RETURN, 0, 0, NOT_PERMITTED),
    ]
    for one in calls.values():
        steps += [(EQUAL, 0, 1, one), (RETURN, 0, 0, NOT_PERMITTED)]
    steps.append((RETURN, 0, 0, ALLOW))
    with tempfile.TemporaryFile() as file:
        file.write(b"".join(struct.pack("HBBI", *step) for step in steps))
        file.flush()
        file.seek(0)
        yield file.fileno()


def python() -> str:
    """Return the Python that the environment was made from."""
    return os.path.realpath(getattr(sys, "_base_executable", sys.executable))


def packages() -> list[str]:
    """Return the folders of the installed packages."""
    paths = sysconfig.get_paths()
    return list(dict.fromkeys([paths["purelib"], paths["platlib"]]))


def wall(library: Path, filter_file: int) -> list[str]:
    """Return the command that closes a box around the command after it."""
    arguments = [
        *("bwrap", "--unshare-all", "--unshare-user", "--disable-userns"),
        *("--die-with-parent", "--new-session", "--cap-drop", "ALL", "--clearenv"),
    ]
    for name in ("/usr", "/lib", "/lib64", "/bin"):
        if os.path.islink(name):
            arguments += ["--symlink", os.readlink(name), name]
        elif os.path.isdir(name):
            arguments += ["--ro-bind", name, name]
    prefix = str(Path(python()).parents[1])
    for folder in [prefix, *packages()]:
        if not folder.startswith("/usr/") and folder != "/usr":
            arguments += ["--ro-bind", folder, folder]
    for folder in packages():  # an installed workbook has the checks
        for name in ("pgm_lab", "pgm_book"):
            if (Path(folder) / name).is_dir():
                arguments += ["--tmpfs", f"{folder}/{name}"]
    boxed = str(Path(worker.__file__).parent)
    arguments += ["--ro-bind", boxed, "/box"]
    arguments += ["--ro-bind", str(library), "/library"]  # and no /proc
    arguments += ["--dev", "/dev", "--remount-ro", "/dev"]
    arguments += ["--size", str(ROOM), "--tmpfs", HOME, "--chdir", HOME]
    arguments += ["--seccomp", str(filter_file), "--remount-ro", "/"]
    for name, value in VARIABLES.items():
        arguments += ["--setenv", name, value]
    return arguments


def alike(one: Any, other: Any) -> bool:
    """Whether two answers are the same, up to how sums were rounded."""
    if type(one) is not type(other):
        return False
    if isinstance(one, list | tuple):
        return len(one) == len(other) and all(map(alike, one, other))
    if isinstance(one, dict):
        return alike([*one.items()], [*other.items()])
    if isinstance(one, np.ndarray | float | complex):
        if np.shape(one) != np.shape(other):
            return False
        if np.asarray(one).dtype.kind in "fc":
            return np.allclose(one, other, rtol=1e-5, atol=1e-9, equal_nan=True)
        return np.array_equal(one, other)
    return isinstance(one, plain.Fields) or one == other


class Box:
    """One process with a student's code; ``with Box(library) as box``."""

    def __init__(self, library: Path, trusted: bool = False) -> None:
        self.folder = tempfile.TemporaryDirectory(ignore_cleanup_errors=True)
        self.until = time.monotonic() + WHOLE
        self.why = ""  # it gives no answer
        self.remarks: list[str] = []
        self.functions: dict[int, Callable] = {}
        self.callbacks = itertools.count(1)
        kept = contextlib.nullcontext(-1) if trusted else filtered()
        with kept as number:
            home = self.folder.name
            around = [] if trusted else wall(library, number)
            box = str(worker.__file__) if trusted else "/box/worker.py"
            path = [str(library) if trusted else "/library", *packages()]
            self.process = subprocess.Popen(
                [*around, python(), "-I", "-S", box, *path],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
                cwd=home,
                # Nothing of the lecturer's, for bubblewrap's own is read in the box
                env=VARIABLES | {"HOME": home, "TMPDIR": home} | WINDOWS,
                start_new_session=True,
                pass_fds=[] if trusted else [number],
            )

    def __enter__(self) -> "Box":
        return self

    def __exit__(self, *error: object) -> None:
        self.stop(CLOSED)
        for pipe in (self.process.stdin, self.process.stdout):
            with contextlib.suppress(OSError):
                pipe.close()  # type: ignore[union-attr]
        self.process.wait()
        self.folder.cleanup()

    def stop(self, why: str) -> None:
        """End the process, and all that it started."""
        if not self.why:
            self.why = why
            self.remarks += [why] if why != CLOSED else []
        if os.name == "posix":
            with contextlib.suppress(ProcessLookupError):
                os.killpg(self.process.pid, signal.SIGKILL)
        else:
            command = ["taskkill", "/T", "/F", "/PID", str(self.process.pid)]
            subprocess.run(command, capture_output=True, check=False)

    def ask(self, seconds: float, **request: Any) -> Any:
        """Return what the box answers to a request.

        Raises
        ------
        NoAnswer
            If it answers nothing in time, or too much, or no longer.
        Exception
            Of the class that the student's code raised, if that is one of Python's.
        """
        why = f"it gave no answer in {seconds:.0f} seconds"
        if (left := self.until - time.monotonic()) < seconds:
            seconds, why = left, f"it took more than {WHOLE:.0f} seconds in all"
        timer = threading.Timer(seconds, self.stop, [why])
        timer.start()
        try:
            answer = self.exchanged(request)
            while "call" in answer:
                answer = self.exchanged(self.called(answer))
        finally:
            timer.cancel()
        if "error" in answer:
            raise self.error(answer["error"])
        return answer.get("value")

    def exchanged(self, request: dict) -> dict:
        """Write one line, and read one."""
        assert self.process.stdin is not None and self.process.stdout is not None
        line = b""
        if not self.why:
            with contextlib.suppress(OSError):  # it may have ended
                self.process.stdin.write(json.dumps(request).encode() + b"\n")
                self.process.stdin.flush()
            line = self.process.stdout.readline(worker.BYTES + 1000)
        if not line.endswith(b"\n"):
            self.stop("its answer is too long" if line else "it ended its process")
            raise NoAnswer(self.why)
        try:
            answer = json.loads(line)
        except (ValueError, RecursionError):
            answer = None
        if not isinstance(answer, dict):
            self.stop("its answer is not readable")
            raise NoAnswer(self.why)
        return answer

    def called(self, asked: dict) -> dict:
        """Answer a call of a function of the judge's."""
        if next(self.callbacks) > CALLBACKS:
            self.stop("it called a function too often")
            raise NoAnswer(self.why)
        try:
            arguments = plain.unpacked(asked["arguments"])
            return {"value": plain.packed(self.functions[asked["call"]](*arguments))}
        except Exception as error:
            return {"error": f"{type(error).__name__}: {str(error)[:200]}"}

    def error(self, described: Any) -> Exception:
        """Return the error of the student's code, to be raised here."""
        kind, said, missing = ([str(one)[:500] for one in described] + 3 * [""])[:3]
        self.remarks.append(named(f"{kind}: {said}" if said else kind))
        if kind == "BooksOwn":
            return BooksOwn(said)
        found = getattr(np.linalg if kind == "LinAlgError" else builtins, kind, None)
        if not (isinstance(found, type) and issubclass(found, BaseException)):
            found = RuntimeError
        if issubclass(found, NameError):
            return found(said, name=missing)  # as the checks read it
        if issubclass(found, Exception):
            with contextlib.suppress(TypeError):  # a UnicodeError takes five
                return found(said)
        return RuntimeError(f"{kind}: {said}" if said else kind)

    def function(self, name: str, seed: int = 0) -> Callable:
        """Return the student's function of a name, to be called like any other.

        Some calls, as `seed` decides, are made twice: who gives the notebook's answers
        in their order, whatever is asked, does not know which.
        """
        chance = random.Random(seed)

        def boxed(*arguments: Any, **named: Any) -> Any:
            request = {
                "arguments": [plain.packed(a, self.kept) for a in arguments],
                "named": plain.packed(named, self.kept),
            }
            found = self.called_once(name, request)
            if chance.random() < 0.5 and not alike(
                found[0], self.called_once(name, request)[0]
            ):
                raise RuntimeError("it gave two answers to the same question")
            for k, values in found[1].items():
                np.copyto(arguments[k], values)
            return found[0]

        boxed.__name__ = name
        boxed.boxed = True  # type: ignore[attr-defined]
        return boxed

    def called_once(self, name: str, request: dict) -> tuple[Any, dict[int, Any]]:
        """Return an answer, and the arguments that the call changed."""
        said = self.ask(CALLING, do="call", name=name, **request)
        try:
            changed = {int(k): plain.unpacked(v) for k, v in said["changed"].items()}
            return plain.unpacked(said["answer"]), changed
        except (LookupError, TypeError, ValueError, AttributeError):
            raise RuntimeError("its answer is no plain data") from None

    def kept(self, function: Callable) -> int:
        """Keep a function of the judge's, which the box may call by its number."""
        self.functions[len(self.functions)] = function  # no address leaves the judge
        return len(self.functions) - 1
