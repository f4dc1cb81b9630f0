"""The site: every chapter, the guides, the glossary, the verdicts and the reference.

`build` makes Sphinx's source pages anew in ``build/site-source`` and the static site in
``build/site``. Each kind of page has a module with a function ``write``, which puts its
pages into the folder of the sources and returns their names for the table of contents.
"""
