"""Print the truth behind a student's task: truths.py LESSON NAME [SECRET].

For example `.venv/bin/python truths.py 4 "Siti Rahma"`. The data are made from the
name, and from the secret word if you gave one to `task.start`.
"""

import sys
from pprint import pprint

from pgm_book import task

mine = task.start(*sys.argv[1:])
print(f"{mine}; values {mine.digest[:16]}")
pprint(mine._truth)
