"""Run one task of the workbook: `python tasks.py NAME [arguments]`.

Works with any Python from 3.11 on, on Linux, macOS and Windows, and needs nothing
installed: each task sets up the folder .venv by itself when it is missing or stale.
`python tasks.py` alone lists the tasks.
"""

import os
import sys

if sys.version_info < (3, 11):
    sys.exit(
        "This workbook needs Python 3.11 or newer; this is Python %d.%d (%s).\n"
        "Start it with a newer one, for example: python3.11 tasks.py test, "
        "or make test PYTHON=python3.11"
        % (sys.version_info[0], sys.version_info[1], sys.executable)
    )

# With PYTHONSAFEPATH set Python would not look beside this file.
sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

from pgm_book.make.commands import main  # noqa: E402  (older Pythons must not get this far)

if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
