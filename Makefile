# Every target is a task of tasks.py, which also runs without make.
# Arguments: make test ARGS="-k frames"; another Python: make test PYTHON=python3.12
# One lesson alone: make test LESSON=3; a paper: make exam SEED=7

PYTHON ?= python3
TASKS = lab test test-slow test-all test-oldest test-publish chapter notebooks slides \
	handouts site quiz exam requirements benchmark mutations house

.PHONY: help student course release grade $(TASKS)

help:
	@$(PYTHON) tasks.py

# make grade SUBMISSIONS=folder LESSON="2 A1" RUBRIC=file SECRET=word TRUSTED=yes
grade:
	@$(PYTHON) tasks.py grade "$(SUBMISSIONS)" $(if $(LESSON),--lessons $(LESSON)) \
		$(if $(RUBRIC),--rubric "$(RUBRIC)") $(if $(SECRET),--secret "$(SECRET)") \
		$(if $(filter yes,$(TRUSTED)),--trusted) $(ARGS)

# make student FORMAT=nbgrader, or FORMAT=otter
student:
	@$(PYTHON) tasks.py student $(LESSON) $(if $(FORMAT),--format $(FORMAT)) $(ARGS)

# make course WHEELS=windows,linux,macos PYTHONS=3.12,3.13
course:
	@$(PYTHON) tasks.py course $(LESSON) $(if $(WHEELS),--wheels $(WHEELS)) \
		$(if $(PYTHONS),--pythons $(PYTHONS)) $(ARGS)

# make release CHECK=yes: twice, and compared
release:
	@$(PYTHON) tasks.py release $(if $(filter yes,$(CHECK)),--check) $(ARGS)

$(TASKS):
	@$(PYTHON) tasks.py $@ $(SEED) $(LESSON) $(ARGS)
