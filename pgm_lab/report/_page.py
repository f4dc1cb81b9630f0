"""The report of a bundle adjustment as one HTML page, figures included."""

import jinja2

from pgm_lab.bundle.result import Bundle
from pgm_lab.bundle.snooping import Snooping
from pgm_lab.report._text import is_number, sections

TALL = 25  # rows of a table that is scrolled in a frame of its own

STYLE = """
:root { color-scheme: light dark; --ink: #1d1d1f; --paper: #ffffff; --soft: #5a5a60;
  --line: #d2d2d7; --head: #eef1f5; --mark: #0b5cad; --warn: #fff6e0; --edge: #b26a00; }
@media (prefers-color-scheme: dark) { :root { --ink: #ececf0; --paper: #17181b;
  --soft: #b4b4bd; --line: #43444b; --head: #25272c; --mark: #8cc4ff;
  --warn: #2e2617; --edge: #e3a94a; } }
body { background: var(--paper); color: var(--ink); margin: 0 auto; max-width: 68rem;
  padding: 1.5rem; font: 1rem/1.5 system-ui, sans-serif; }
h1 { margin-bottom: 0.3rem; } h2 { margin-top: 2.5rem; }
main p { max-width: 46rem; } .lead { font-size: 1.15rem; }
a { color: var(--mark); }
nav ul { display: flex; flex-wrap: wrap; gap: 0.3rem 1.2rem; list-style: none;
  padding: 0; }
dl div { background: var(--warn); border-left: 0.3rem solid var(--edge);
  margin: 0.6rem 0; max-width: 46rem; padding: 0.5rem 0.9rem; }
dt { font-weight: 600; } dd { margin: 0; }
.table { border-bottom: 1px solid var(--line); margin: 1.2rem 0; overflow: auto;
  width: fit-content; max-width: 100%; }
.tall { border: 1px solid var(--line); max-height: 32rem; padding: 0 0.5rem; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; }
caption { color: var(--soft); padding: 0.3rem 0; text-align: left; }
th, td { border-top: 1px solid var(--line); padding: 0.2rem 0.7rem; text-align: right;
  white-space: nowrap; }
thead th { background: var(--head); position: sticky; top: 0; }
.words { text-align: left; }
tbody th { font-weight: 600; }
figure { margin: 1.2rem 0; }
img { background: white; border-radius: 0.4rem; height: auto; max-width: 100%; }
figcaption, footer { color: var(--soft); }
@media print { .tall { max-height: none; } nav { display: none; } }
"""

TEMPLATE = """<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{{ title }}</title>
<style>{{ style }}</style>
</head>
<body>
<header>
<h1>{{ title }}</h1>
<nav aria-label="Sections"><ul>
{% for section in sections[1:] %}<li><a href="#s{{ loop.index }}">{{ section.title }}\
</a></li>
{% endfor %}</ul></nav>
</header>
<main>
{% for section in sections %}
<section id="s{{ loop.index0 }}">
{% if not loop.first %}<h2>{{ section.title }}</h2>{% endif %}
{% for words in section.paragraphs %}
<p{% if loop.first and section is sameas sections[0] %} class="lead"{% endif %}>\
{{ words }}</p>
{% endfor %}
{% if section.findings %}<dl>
{% for finding in section.findings %}
<div><dt>{{ finding.title }}</dt><dd>{{ finding.words }}</dd></div>
{% endfor %}</dl>{% endif %}
{% for table in section.tables %}{% set words = left(table) %}
<div class="table{% if table.rows|length > tall %} tall{% endif %}" role="region"
 tabindex="0" aria-label="{{ table.caption }}">
<table>
<caption>{{ table.caption }}</caption>
<thead><tr>{% for cell in table.header %}<th scope="col"\
{% if words[loop.index0] %} class="words"{% endif %}>{{ cell }}</th>{% endfor %}</tr>\
</thead>
<tbody>
{% for row in table.rows %}<tr>{% for cell in row %}{% set tag = "td" if loop.index0 \
else "th" %}<{{ tag }}{% if loop.first %} scope="row"{% endif %}\
{% if words[loop.index0] %} class="words"{% endif %}>{{ cell }}</{{ tag }}>\
{% endfor %}</tr>
{% endfor %}</tbody>
</table>
</div>
{% endfor %}
{% for name in section.figures %}{% for picture, alt in pictures(name) %}
<figure><img src="data:image/png;base64,{{ picture }}" alt="{{ alt }}"></figure>
{% endfor %}{% endfor %}
</section>
{% endfor %}
</main>
</body>
</html>
"""


def html(found: Bundle | Snooping, *, about: str = "") -> str:
    """Report a bundle adjustment as an HTML page that needs nothing beside itself.

    Parameters
    ----------
    found : Bundle or Snooping
        What `adjust` or `snoop` returns.
    about : str
        A sentence for the head of the report: the object, the files, the date.

    Returns
    -------
    str
        The page with its figures, for light and dark screens and for paper.
    """
    result = found.result if isinstance(found, Snooping) else found
    environment = jinja2.Environment(
        autoescape=True, trim_blocks=True, undefined=jinja2.StrictUndefined
    )
    from pgm_lab.report import _figures

    return environment.from_string(TEMPLATE).render(
        title="Bundle adjustment",
        style=STYLE,
        sections=sections(found, about, short=False),
        pictures=lambda name: _figures.pictures(name, result),
        left=lambda table: [not is_number(cells) for cells in zip(*table.rows)],
        tall=TALL,
    )
