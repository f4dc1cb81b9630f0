"""Set up the workbook in this folder, and open it: START.html says how.

It needs Python 3.11 or newer and nothing else; where the folder wheels stands beside
it, no network either. `--install` sets up without opening.
"""

import os
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
VENV, WHEELS = HERE / ".venv", HERE / "wheels"
READY = VENV / "ready.txt"  # written last: what was interrupted is done again


def main() -> int:
    """Install what is missing, then open the first notebook."""
    if sys.version_info < (3, 11):  # noqa: UP036 (a student's may be older)
        return refuse("Python 3.11 or newer is needed.")
    python = VENV / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
    if not READY.exists():
        if WHEELS.is_dir() and not made_for_this():
            made = (WHEELS / "made_for.txt").read_text(encoding="utf-8")
            return refuse(f"The folder wheels is for another Python:\n{made}")
        print("Setting up, once; this takes some minutes ...", flush=True)
        (library,) = HERE.glob("pgm_lab-*.whl")
        try:
            subprocess.run([sys.executable, "-m", "venv", VENV], check=True)
            pip = [python, "-m", "pip", "--disable-pip-version-check", "install", "-q"]
            if WHEELS.is_dir():
                pip += ["--no-index", "--find-links", WHEELS]
            subprocess.run([*pip, "-r", HERE / "requirements.txt"], check=True)
            subprocess.run([*pip, "--no-deps", library], check=True)
        except subprocess.CalledProcessError:
            return refuse("It was not set up; the lines above say why. Run it again.")
        READY.write_text(f"{library.name}\n", encoding="utf-8")
    if sys.argv[1:] == ["--install"]:
        return 0
    first = min(path.name for path in (HERE / "notebooks").glob("*.ipynb"))
    lab = [python, "-m", "jupyterlab", first]
    return subprocess.run(lab, cwd=HERE / "notebooks").returncode


def made_for_this() -> bool:
    """Whether one of the lines of wheels/made_for.txt names this Python."""
    import platform

    machine = platform.machine().lower().replace("amd64", "x86_64")
    machine = machine.replace("aarch64", "arm64")
    this = (
        f"{sys.platform} {machine} Python {sys.version_info[0]}.{sys.version_info[1]}"
    )
    lines = (WHEELS / "made_for.txt").read_text(encoding="utf-8").splitlines()
    return this in lines


def refuse(said: str) -> int:
    """Say what is wrong, and which Python this is."""
    print(f"{said}\nThis is {sys.executable}, {sys.platform}, Python {sys.version}.")
    return 1


if __name__ == "__main__":
    sys.exit(main())
