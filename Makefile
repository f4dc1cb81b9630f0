# Every target is a task of tasks.py, which also runs without make.
# Arguments: make test ARGS="-k frames"; another Python: make test PYTHON=python3.12
# One lesson alone: make test LESSON=3; a paper: make exam SEED=7

PYTHON ?= python3
TASKS = lab test test-slow test-all test-oldest test-publish chapter notebooks slides \
	handouts site student quiz exam requirements benchmark mutations house

.PHONY: help grade $(TASKS)

help:
	@$(PYTHON) tasks.py

# make grade SUBMISSIONS=folder LESSON="2 A1" RUBRIC=file SECRET=word TRUSTED=yes
grade:
	@$(PYTHON) tasks.py grade "$(SUBMISSIONS)" $(if $(LESSON),--lessons $(LESSON)) \
		$(if $(RUBRIC),--rubric "$(RUBRIC)") $(if $(SECRET),--secret "$(SECRET)") \
		$(if $(filter yes,$(TRUSTED)),--trusted) $(ARGS)

$(TASKS):
	@$(PYTHON) tasks.py $@ $(SEED) $(LESSON) $(ARGS)
