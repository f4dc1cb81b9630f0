"""Matching tested on photos that were not made for it.

``python -m pgm_book.common.real_pairs FOLDER`` prints one table: what `ncc.match`,
`lsm.match` and `matching.match` do on the pairs whose files lie somewhere in FOLDER, on
those that come with the project and on some that are made from them. ``--fetch`` gets
the files first; `pairs` says where from, and under which licence. All is seeded.
"""
