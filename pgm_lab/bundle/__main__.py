"""A door to the command line of `pgm_lab.report`: python -m pgm_lab.bundle."""

import sys

from pgm_lab.report.__main__ import main

if __name__ == "__main__":
    sys.exit(main())
