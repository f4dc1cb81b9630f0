"""Settings of nbgrader for the assignments in source/, each of them a notebook.

    nbgrader generate_assignment 04_rotation_matrices    release/ is for students
    nbgrader autograde 04_rotation_matrices              of submitted/NAME/04_...
    nbgrader export                                      grades.csv

Install nbgrader into the environment of the workbook: its kernel needs pgm_lab. The
cells of a submission run as you, with all your rights: grade in a container, or with
`make grade`, which locks each student's code in a box.
"""

c = get_config()  # noqa: F821
c.CourseDirectory.course_id = "pgm_lab"
c.ClearSolutions.code_stub = {"python": "{placeholder}"}
c.Execute.timeout = 300  # seconds, of a cell
c.ExecutePreprocessor.timeout = 300
