SHELL := /bin/bash
# make demo   set up and run the main job on a sample
# make test   set up and run every check: pytest, ctest, ruff, mypy
PYTHON ?= python3
VENV ?= .venv
BIN := $(VENV)/bin
NATIVE_BUILD := build/native
SOURCES := $(shell find neurframe_cli native -type f -not -path '*/__pycache__/*') pyproject.toml README.md LICENSE
PIP := $(BIN)/python -m pip --quiet --disable-pip-version-check
JOBS ?= 2

.PHONY: install demo test lint types pytest ctest format samples clean

install: $(VENV)/.package

$(VENV)/.dependencies: pyproject.toml constraints.txt
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { echo "make: Python 3.11 or newer is needed; set PYTHON=..." >&2; exit 2; }
	@test -x $(BIN)/python || $(PYTHON) -m venv $(VENV) || { echo "make: no virtual environment; on Debian and Ubuntu: apt-get install python3-venv" >&2; exit 2; }
	$(PIP) install -c constraints.txt "$$(grep '^torch==' constraints.txt)"
	$(PIP) install -c constraints.txt -r <($(BIN)/python tests/requirements.py)
	touch $@

$(VENV)/.package: $(VENV)/.dependencies $(SOURCES)
	$(PIP) install --no-deps --force-reinstall .
	touch $@

demo: install
	$(BIN)/neurframe run samples/bracket.stl -w demo/bracket.neurframe

test: install lint types ctest pytest

lint: $(VENV)/.dependencies
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	git ls-files 'native/*.hpp' 'native/*.cpp' | xargs $(BIN)/clang-format --dry-run --Werror

types: $(VENV)/.dependencies
	$(BIN)/mypy

ctest: $(VENV)/.dependencies
	$(BIN)/cmake -S native -B $(NATIVE_BUILD) -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_MAKE_PROGRAM=$(abspath $(BIN)/ninja) -DPython3_EXECUTABLE=$(abspath $(BIN)/python)
	$(BIN)/cmake --build $(NATIVE_BUILD) -j $(JOBS)
	$(BIN)/ctest --test-dir $(NATIVE_BUILD) --output-on-failure

pytest: install
	$(BIN)/python -P -m pytest -q

format: $(VENV)/.dependencies
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .
	git ls-files 'native/*.hpp' 'native/*.cpp' | xargs $(BIN)/clang-format -i

samples: install
	$(BIN)/python samples/make_samples.py

clean:
	rm -rf build demo $(VENV)
