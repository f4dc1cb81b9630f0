"""Pytest starts 1.4 seconds earlier, and so does each of its workers.

nbval loads jsonschema, which would make dozens of grammars of international addresses
at once; no notebook's schema asks for them.
"""

import sys

sys.modules.setdefault("rfc3987_syntax", None)  # as if it were not installed
