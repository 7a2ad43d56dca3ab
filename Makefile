# Two commands do everything, each making its own .venv:
#   make demo   fly a shipped mission with the shipped policy and prove its log
#   make test   the tests
VENV ?= .venv
PYTHON ?= python3
BIN := $(VENV)/bin
INSTALL := $(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt
DEMO_LOG := logs/demo.mcap

.PHONY: demo test test-all check coverage format bench mutate train clean

demo: $(VENV)/.run
	$(BIN)/waypointctl run missions/paper-two-point-moon.yaml --out $(DEMO_LOG) --force
	$(BIN)/waypointctl replay $(DEMO_LOG)

test: $(VENV)/.dev
	$(BIN)/python -m pytest -n 2 -m "not slow"

test-all: $(VENV)/.dev # with rerun, half a gigabyte, and all that is slow
	$(INSTALL) --editable ".[dev,viewers]"
	THOROUGH=1 $(BIN)/python -m pytest -n 2

check: $(VENV)/.dev
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy

coverage: $(VENV)/.dev # line coverage, subprocesses included
	$(BIN)/python -m pytest -n 2 -m "not slow" --cov --cov-report=term:skip-covered

format: $(VENV)/.dev
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

bench: $(VENV)/.dev
	$(BIN)/python bench/env_speed.py
	$(BIN)/python bench/flight_speed.py
	$(BIN)/python bench/log_write.py
	$(BIN)/python bench/train_speed.py

mutate: $(VENV)/.dev # half an hour; SAMPLE="executive --sample 100" runs some
	$(BIN)/python bench/mutate.py $(SAMPLE)

train: $(VENV)/.dev
	$(BIN)/waypointctl train policies/ant-waypoint/train.yaml

clean:
	rm -rf $(VENV) build dist .mypy_cache .pytest_cache .ruff_cache .import_linter_cache

$(VENV)/.run: pyproject.toml constraints.txt
	$(PYTHON) -m venv $(VENV)
	$(INSTALL) --editable .
	touch $@

$(VENV)/.dev: pyproject.toml constraints.txt
	$(PYTHON) -m venv $(VENV)
	$(INSTALL) --editable ".[dev]"
	touch $@ $(VENV)/.run
