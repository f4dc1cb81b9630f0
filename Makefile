# Every target is a task of tasks.py, which also runs without make.
# Arguments: make test ARGS="-k frames"; another Python: make test PYTHON=python3.12
# One lesson alone: make test LESSON=3

PYTHON ?= python3
TASKS = lab test test-slow test-all test-oldest test-publish chapter notebooks slides \
	handouts site student requirements benchmark mutations house

.PHONY: help $(TASKS)

help:
	@$(PYTHON) tasks.py

$(TASKS):
	@$(PYTHON) tasks.py $@ $(LESSON) $(ARGS)
