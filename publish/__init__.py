"""Slides, handouts and student copies, made from the notebooks alone.

Run ``python -m publish slides|handouts|student|sizes [NAME ...]`` in the folder of the
project.
"""
