"""What exists for the workbook alone: its lessons, and what makes files from them.

``make`` turns the notebooks into slides, handouts, copies and the site, and keeps the
repository in order.
"""
