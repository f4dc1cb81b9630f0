"""`python -m pgm_lab`, the same as the command `pgm_lab`."""

import sys

from pgm_lab.command import main

if __name__ == "__main__":
    sys.exit(main())
