SHELL := /bin/bash
# make demo   set up and run the main job on a sample
# make test   set up and run every check: pytest, ctest, ruff, mypy
PYTHON ?= python3
VENV ?= .venv
BIN := $(VENV)/bin
NATIVE_BUILD := build/native
SOURCES := $(shell find neurframe_cli native -type f -not -path '*/__pycache__/*') pyproject.toml README.md LICENSE
PIP := $(BIN)/python -m pip --quiet --disable-pip-version-check
JOBS ?= $(shell nproc)
export CMAKE_BUILD_PARALLEL_LEVEL ?= $(JOBS)

DOCKER ?= docker

# make batch  a subset of Thingi10K: make batch THINGI10K=FOLDER, or without it from the data set (several GB);
#             BATCH_OPTIONS="--quality draft --jobs 4" and the like; batch-dask: SCHEDULER=ADDRESS, else workers here
BATCH_MODELS ?= benchmarks/thingi10k.txt
BATCH_OUTPUT ?= batch
BATCH_OPTIONS ?=
BATCH := $(BIN)/neurframe batch $(BATCH_MODELS) -o $(BATCH_OUTPUT) --resume --jobs $(JOBS) $(if $(THINGI10K),--thingi10k "$(THINGI10K)")

# make fuzz      libFuzzer on the C++ readers for FUZZ_SECONDS each (needs clang), then FUZZ_CASES damaged files per reader
# make sanitize  ctest, and the executables over NEURFRAME_MODELS, under ASan + UBSan and under TSan with four threads
#                both with clang, in build/sanitize-*; CMAKE_OPTIONS=-DCMAKE_UNITY_BUILD=ON builds faster, all at once
CLANG ?= clang++
FUZZ_SECONDS ?= 60
FUZZ_CASES ?= 1000
CMAKE_NATIVE = $(BIN)/cmake -S native -G Ninja -DCMAKE_BUILD_TYPE=RelWithDebInfo -DNEURFRAME_STRICT=OFF \
  -DCMAKE_MAKE_PROGRAM=$(abspath $(BIN)/ninja) \
  -DCMAKE_PREFIX_PATH="$$($(BIN)/python -c 'import sysconfig; print(sysconfig.get_path("purelib"))')/cmeel.prefix" \
  -DCMAKE_CXX_COMPILER=$(CLANG) $(CMAKE_OPTIONS)
CMAKE_ADDRESS = $(CMAKE_NATIVE) -B build/sanitize-address -DNEURFRAME_FUZZ=ON

.PHONY: docs install demo test lint types pytest ctest fuzz sanitize format samples docker docker-cuda batch batch-dask batch-slurm clean

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

# the same build folder with the unit tests of the executables, and with warnings as errors
$(VENV)/.package-with-tests: $(VENV)/.dependencies $(SOURCES)
	$(PIP) install --no-deps --force-reinstall -C cmake.define.NEURFRAME_TESTS=ON -C cmake.define.NEURFRAME_STRICT=ON .
	touch $@ $(VENV)/.package

demo: install
	$(BIN)/neurframe run samples/bracket.stl -w demo/bracket.neurframe

test: lint types ctest pytest

lint: $(VENV)/.dependencies
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	git ls-files 'native/*.hpp' 'native/*.cpp' | xargs $(BIN)/clang-format --dry-run --Werror

types: $(VENV)/.dependencies
	$(BIN)/mypy

ctest: $(VENV)/.package-with-tests
	$(BIN)/ctest --test-dir $(NATIVE_BUILD) --output-on-failure -j $(JOBS)

pytest: $(VENV)/.package-with-tests
	$(BIN)/python -P -m pytest -q -n $(JOBS)

$(VENV)/.eigen: $(VENV)/.dependencies
	$(PIP) install cmeel-eigen
	touch $@

fuzz: install $(VENV)/.eigen
	$(CMAKE_ADDRESS)
	$(BIN)/cmake --build build/sanitize-address --target fuzz_harnesses
	build/sanitize-address/fuzz/write_seeds build/fuzz/seeds
	set -e; for harness in build/fuzz/seeds/*; do name=$$(basename $$harness); mkdir -p build/fuzz/corpus/$$name; \
	  build/sanitize-address/fuzz/fuzz_$$name -max_total_time=$(FUZZ_SECONDS) -max_len=4096 -timeout=60 -rss_limit_mb=2048 \
	    -print_funcs=0 -print_final_stats=1 -dict=native/fuzz/hostile.dict -artifact_prefix=build/fuzz/$$name- build/fuzz/corpus/$$name $$harness; done
	NEURFRAME_FUZZ_CASES=$(FUZZ_CASES) $(BIN)/python -P -m pytest -q -n $(JOBS) tests/test_fuzz.py tests/test_mesh_fuzz.py

sanitize: install $(VENV)/.eigen
	$(CMAKE_ADDRESS)
	$(CMAKE_NATIVE) -B build/sanitize-thread -DNEURFRAME_SANITIZE=thread
	set -e; for kind in address thread; do $(BIN)/cmake --build build/sanitize-$$kind; \
	  $(BIN)/ctest --test-dir build/sanitize-$$kind --output-on-failure -j $(JOBS) -LE fuzz; done
	$(BIN)/python tests/run_sanitized.py build/sanitize-address
	$(BIN)/python tests/run_sanitized.py build/sanitize-thread --threads 4

format: $(VENV)/.dependencies
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .
	git ls-files 'native/*.hpp' 'native/*.cpp' | xargs $(BIN)/clang-format -i

samples: install
	$(BIN)/python samples/make_samples.py

$(VENV)/.extra-%: $(VENV)/.dependencies
	$(PIP) install -c constraints.txt -r <($(BIN)/python tests/requirements.py $*)
	touch $@

batch: install $(if $(THINGI10K),,$(VENV)/.extra-thingi10k)
	$(BATCH) $(BATCH_OPTIONS)

batch-dask: install $(VENV)/.extra-batch $(if $(THINGI10K),,$(VENV)/.extra-thingi10k)
	$(BATCH) --scheduler $(or $(SCHEDULER),loopback) $(BATCH_OPTIONS)

batch-slurm: install $(VENV)/.extra-batch $(if $(THINGI10K),,$(VENV)/.extra-thingi10k)
	$(BATCH) --scheduler slurm $(BATCH_OPTIONS)

# the documentation site, in build/site; warnings are errors
docs: install
	$(PIP) install -c constraints.txt .[docs]
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --quiet

docker:
	$(DOCKER) build -f docker/Dockerfile -t neurframe --build-arg TORCH_INDEX=https://download.pytorch.org/whl/cpu .

docker-cuda:
	$(DOCKER) build -f docker/Dockerfile -t neurframe:cuda .

clean:
	rm -rf build demo $(VENV)
