"""What runs and lies in the box, beside a student's code; nothing here knows an answer.

``worker``, ``plain`` and ``nothing`` import only each other; ``checks`` and ``task``
stand in the students' library for the book's.
"""
