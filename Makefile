# make demo   set up what is needed and run the bench's main job
# make test   set up what is needed and run the tests
# Both need Python 3.11 or newer and git; everything is installed into .venv.

VENV     := .venv
ATTACK   := .venv-attack
VALIDATE := .venv-validate
PYTHON   := $(VENV)/bin/python

# $(call install,ENVIRONMENT,EXTRAS,WORDS). What pip says is shown where it fails, but the first of its retries alone.
comma := ,
define install
@echo "installing $(3) into $(1), once; this takes a minute or two ..." >&2
@$(1)/bin/python -m pip install --quiet --quiet --disable-pip-version-check -e '.$(2)' 2> $(1)/pip.log || { \
  awk '!/^ *WARNING: Retrying/ || !retries++' $(1)/pip.log >&2; \
  echo "wheelbench: pip could not install into $(1), and says why above; it needs a network this once: try again with one" >&2; \
  exit 3; }
endef

.PHONY: demo test lint bench compiled socketcan gamepad fuzz mutate validate clean

demo: $(VENV)/.run
	@$(VENV)/bin/wheelbench demo

test: $(VENV)/.dev
	@$(PYTHON) -m pytest

lint: $(VENV)/.dev
	@$(PYTHON) -m ruff check . && $(PYTHON) -m ruff format --check . && $(PYTHON) -m mypy

bench: $(VENV)/.dev
	@$(PYTHON) scripts/benchmark.py

# Some minutes, with a C compiler: the core compiled from the same source gives the same bytes, and how much faster.
compiled: $(VENV)/.dev
	@$(PYTHON) scripts/compiled.py

# The tests that need Linux's own CAN (half a minute) or its input layer (two to four minutes, in software emulation),
# under a kernel that has it. 125 is a machine where that cannot boot.
socketcan gamepad: $(VENV)/.dev
	@scripts/kernels/run.sh $@ $(PYTHON) -m pytest -n 0 -p no:cacheprovider -m $@ \
	  $$(grep -l pytest.mark.$@ tests/test_*.py) || { status=$$?; [ $$status = 125 ] || exit $$status; \
	  echo "make $@: skipped, for the reason above" >&2; }

gamepad: $(VENV)/.evdev

# About an hour: 100 MB of noise for every decoder, then ten minutes of atheris for each. See docs/attack.md.
fuzz: $(ATTACK)/.stamp
	@$(ATTACK)/bin/python scripts/noise.py --mb 100 && $(ATTACK)/bin/python scripts/fuzz.py --seconds 600 --jobs 2

# Some hours on a busy machine: every mutant of the codecs and the link machine. See docs/attack.md.
mutate: $(VENV)/.dev
	@$(PYTHON) scripts/mutate.py

# Two minutes: the plant beside MuJoCo with every roller a body, and that a wrong plant is seen. See docs/plant.md.
validate: $(VALIDATE)/.stamp
	@$(VALIDATE)/bin/python -m pytest -n 0 tests/test_validate.py && $(VALIDATE)/bin/python scripts/validate.py

clean:
	rm -rf $(VENV) $(ATTACK) $(VALIDATE) .socketcan .gamepad

$(VENV)/bin/python:
	@found=; for python in python3 python3.14 python3.13 python3.12 python3.11; do \
	  if $$python -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null; then found=$$python; break; fi; done; \
	if [ -z "$$found" ]; then echo "wheelbench needs Python 3.11 or newer; none of python3, python3.11 .. python3.14 is one" >&2; exit 3; fi; \
	$$found -m venv $(VENV) || { rm -rf $(VENV); exit 3; }

$(VENV)/.run: pyproject.toml | $(VENV)/bin/python
	$(call install,$(VENV),,wheelbench)
	@touch $@

$(VENV)/.dev: pyproject.toml | $(VENV)/bin/python
	$(call install,$(VENV),[dev],wheelbench and its development tools)
	@touch $@ $(VENV)/.run

# It has to be compiled. Where it cannot be, the tests that read event devices skip and say so.
$(VENV)/.evdev: pyproject.toml | $(VENV)/.dev
	@$(PYTHON) -m pip install --quiet --quiet --disable-pip-version-check 'evdev>=1.6' 2> $(VENV)/pip.log \
	  || echo "make gamepad: evdev does not install here, $(VENV)/pip.log has why" >&2
	@touch $@

# Atheris changes what it runs, so it lives beside the bench's own environment and not in it.
$(ATTACK)/.stamp: pyproject.toml | $(VENV)/bin/python
	@$(PYTHON) -m venv $(ATTACK)
	$(call install,$(ATTACK),[attack],wheelbench and atheris)
	@touch $@

$(VALIDATE)/.stamp: pyproject.toml | $(VENV)/bin/python
	@$(PYTHON) -m venv $(VALIDATE)
	$(call install,$(VALIDATE),[dev$(comma)validate],wheelbench$(comma) its development tools and MuJoCo)
	@touch $@
