# make demo   set up what is needed and run the bench's main job
# make test   set up what is needed and run the tests
# Both need Python 3.11 or newer and git; everything is installed into .venv.

VENV   := .venv
PYTHON := $(VENV)/bin/python
PIP    := $(PYTHON) -m pip install --quiet --disable-pip-version-check

.PHONY: demo test lint bench clean

demo: $(VENV)/.run
	@$(VENV)/bin/wheelbench demo

test: $(VENV)/.dev
	@$(PYTHON) -m pytest

lint: $(VENV)/.dev
	@$(PYTHON) -m ruff check . && $(PYTHON) -m ruff format --check . && $(PYTHON) -m mypy

bench: $(VENV)/.dev
	@$(PYTHON) scripts/benchmark.py

clean:
	rm -rf $(VENV)

$(VENV)/bin/python:
	@found=; for python in python3 python3.14 python3.13 python3.12 python3.11; do \
	  if $$python -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null; then found=$$python; break; fi; done; \
	if [ -z "$$found" ]; then echo "wheelbench needs Python 3.11 or newer; none of python3, python3.11 .. python3.14 is one" >&2; exit 3; fi; \
	$$found -m venv $(VENV)

$(VENV)/.run: pyproject.toml | $(VENV)/bin/python
	@echo "installing wheelbench into $(VENV) ..." >&2
	@$(PIP) -e . && touch $@

$(VENV)/.dev: pyproject.toml | $(VENV)/bin/python
	@echo "installing wheelbench and its development tools into $(VENV) ..." >&2
	@$(PIP) -e '.[dev]' && touch $@ $(VENV)/.run
