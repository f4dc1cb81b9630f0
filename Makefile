# Every target is a task of tasks.py, which also runs without make.
# Arguments: make test ARGS="-k frames"; another Python: make test PYTHON=python3.12
# One lesson alone: make test LESSON=3; of others: make student FORMAT=nbgrader (or otter)
#   make course WHEELS=windows,linux,macos PYTHONS=3.12,3.13    make exam SEED=7
#   make grade SUBMISSIONS=folder LESSON="2 A1" RUBRIC=file SECRET="four words of yours" TRUSTED=yes
#   make release CHECK=yes

PYTHON ?= python3
TASKS = lab test test-slow test-all test-oldest test-publish chapter notebooks \
	slides handouts site student course release grade quiz exam requirements \
	benchmark mutations house

OPTIONS_student = $(if $(FORMAT),--format $(FORMAT))
OPTIONS_course = $(if $(WHEELS),--wheels $(WHEELS)) $(if $(PYTHONS),--pythons $(PYTHONS))
OPTIONS_grade = "$(SUBMISSIONS)" $(if $(RUBRIC),--rubric "$(RUBRIC)") \
	$(if $(SECRET),--secret "$(SECRET)") $(if $(filter yes,$(TRUSTED)),--trusted)
OPTIONS_exam = $(SEED)
OPTIONS_release = $(if $(filter yes,$(CHECK)),--check)

.PHONY: help $(TASKS)

help:
	@$(PYTHON) tasks.py

$(TASKS):
	@$(PYTHON) tasks.py $@ $(OPTIONS_$@) $(LESSON) $(ARGS)
