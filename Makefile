# Two commands do everything: `make run` and `make test`. Both set up .venv by themselves.
PYTHON ?= python3
CONFIG ?= configs/agder.yaml
VENV   := .venv
BIN    := $(VENV)/bin
READY  := $(VENV)/.ready

.PHONY: run test quick-test lint reference clean

run: $(READY)
	$(BIN)/gantry-tau run $(CONFIG) $(ARGS)

test: lint
	$(BIN)/pytest -n 2 --cov --cov-report=term --cov-fail-under=90

quick-test: $(READY)
	$(BIN)/pytest -n 2 -m "not slow"

# Random input for everything that reads a file, a hundred times what `make test` tries; shows how many cases.
FUZZ ?= 100
.PHONY: fuzz
fuzz: $(READY)
	FUZZ=$(FUZZ) $(BIN)/pytest -m fuzz -n 2 --hypothesis-show-statistics

lint: $(READY)
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/lint-imports --no-logo --no-cache

# The small files of a run of the reference machine, kept in git.
REFERENCE := results/reference/agder
reference: $(READY)
	$(BIN)/gantry-tau run configs/agder.yaml --out results/agder --force
	mkdir -p $(REFERENCE)/figures
	cp results/agder/route.csv results/agder/trajectory.csv results/agder/summary.json $(REFERENCE)/
	cp results/agder/figures/*.png $(REFERENCE)/figures/
	$(BIN)/gantry-tau workspace configs/agder.yaml --picture-3d $(REFERENCE)/figures/workspace_3d.png
	$(BIN)/python -m tests.report.picture results/agder/report.html $(REFERENCE)/report.png

# The notebooks as .ipynb files with their outputs, for Jupyter, VS Code or a browser: a minute.
.PHONY: notebooks
notebooks: $(READY)
	$(BIN)/jupytext --quiet --to ipynb notebooks/*.py
	$(BIN)/jupyter execute --inplace notebooks/*.ipynb

# The documentation as HTML in build/docs: half a minute. Every warning is an error, internal links included.
.PHONY: docs docs-tools
docs: $(VENV)/.docs
	$(BIN)/sphinx-build --fail-on-warning --keep-going --nitpicky --quiet --fresh-env docs build/docs

docs-tools: $(VENV)/.docs
$(VENV)/.docs: $(READY)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt --editable ".[docs]"
	touch $@

# Seconds and memory of stage one, alone and beside other solvers: about a quarter of an hour on a quiet machine.
.PHONY: bench
bench: $(READY)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt --editable ".[bench]"
	$(BIN)/python -m tests.benchmarks $(ARGS)

# Stage two: meshes, other solvers and formulations, random tasks and machines: ten minutes. Then the motions of the
# defaults before and after, on fixed tasks and random machines: twenty.
.PHONY: bench-refine
bench-refine: $(READY)
	$(BIN)/python -m tests.benchmarks.refining $(ARGS)
	$(BIN)/python -m tests.benchmarks.refining_motion

# Stage three: grids, lower bound, limited jerk, and what one would use instead: a minute.
.PHONY: bench-retime
bench-retime: $(READY)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt --editable ".[bench]"
	$(BIN)/python -m tests.benchmarks.retiming $(ARGS)

# Programs that read what is exported, for the tests of exports; LinuxCNC comes with apt-get install linuxcnc-uspace.
.PHONY: consumers
consumers: $(READY)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt --editable ".[consumers]"

# The twin: its speed, MuJoCo beside it, stiffness against gravity, and 25 random machines and tasks: twenty minutes.
.PHONY: bench-simulate
bench-simulate: $(READY)
	$(BIN)/python -m tests.benchmarks.simulating $(ARGS)

$(READY): pyproject.toml constraints.txt
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt --editable ".[dev]"
	touch $@

clean:
	rm -rf $(VENV) .mypy_cache .ruff_cache .pytest_cache .hypothesis .coverage*
