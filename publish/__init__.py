"""Slides, handouts and student copies, made from the notebooks alone.

Run ``python -m publish slides|handouts|student [NAME ...]`` in the project folder.
"""
