"""What makes files from the notebooks, or keeps the repository in order.

``python -m pgm_book.make slides|handouts|student|sizes [NAME ...]`` in the folder of
the project. `commands` and `environment` need nothing but Python.
"""
