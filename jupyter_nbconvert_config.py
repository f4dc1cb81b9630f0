"""`jupyter nbconvert --to slides` in this folder makes the project's own slides.

Jupyter reads this file from the folder in which it is called. It concerns slides only.
"""

import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent


def lecture(notebook, resources):
    """Hand the slides to `publish.plain`, which a clone holds but does not install."""
    sys.path.insert(0, str(ROOT))
    from publish import plain

    return plain.lecture(notebook, resources)


c = get_config()  # noqa: F821 (Jupyter gives it to this file)
c.SlidesExporter.preprocessors = [lecture]
c.SlidesExporter.extra_template_basedirs = [str(ROOT / "publish" / "templates")]
c.SlidesExporter.template_name = "pgm_plain"
