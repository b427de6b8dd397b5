# Two commands do everything: `make run` and `make test`. Both set up .venv by themselves, each with what it needs.
PYTHON ?= python3
CONFIG ?= configs/agder.yaml
VENV   := .venv
BIN    := $(VENV)/bin
RUN    := $(VENV)/.run.ready
DEV    := $(VENV)/.dev.ready

# A file of tests runs in one process, which makes what its tests share once; files go in the order of tests/conftest.py.
WORKERS := -n 2 --dist loadfile --no-loadscope-reorder

.PHONY: run test quick-test lint reference clean
# Two installations at a time into one environment would break it.
.NOTPARALLEL:

run: $(RUN)
	$(BIN)/gantry-tau run $(CONFIG) $(ARGS)

test: lint
	$(BIN)/pytest $(WORKERS) --cov --cov-report=term --cov-fail-under=90

quick-test: $(DEV)
	$(BIN)/pytest $(WORKERS) -m "not slow"

# Random input for everything that reads a file, a hundred times what `make test` tries; shows how many cases.
FUZZ ?= 100
.PHONY: fuzz
fuzz: $(DEV)
	FUZZ=$(FUZZ) $(BIN)/pytest -m fuzz -n 2 --hypothesis-show-statistics

lint: $(DEV)
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/lint-imports --no-logo --no-cache

# The small files of a run of the reference machine, kept in git.
REFERENCE := results/reference/agder
reference: $(DEV)
	$(BIN)/gantry-tau run configs/agder.yaml --out results/agder --force
	mkdir -p $(REFERENCE)/figures
	cp results/agder/route.csv results/agder/trajectory.csv results/agder/summary.json $(REFERENCE)/
	cp results/agder/figures/*.png $(REFERENCE)/figures/
	$(BIN)/gantry-tau workspace configs/agder.yaml --picture-3d results/workspace_3d.png
	mv results/workspace_3d.png $(REFERENCE)/figures/
	$(BIN)/python -m tests.report.picture results/agder/report.html $(REFERENCE)/report.png
	$(BIN)/python -m tests.show.page.picture $(REFERENCE)/show.png
	mkdir -p results/reference/agder-bodies
	$(BIN)/gantry-tau check configs/agder-bodies.yaml --picture results/reference/agder-bodies/machine.png
	mkdir -p results/reference/spindle
	$(BIN)/gantry-tau run configs/spindle.yaml --out results/spindle --force
	$(BIN)/gantry-tau check configs/spindle.yaml --picture results/reference/spindle/machine.png
	$(BIN)/python -m tests.benchmarks.swept results/spindle results/reference/spindle/swept.png

# The studies that are kept in git, with their pictures: of 4-DOF machines, ten minutes; of the machine's dimensions, some.
STUDIES := four_dof design
.PHONY: reference-study reference-design
reference-study: reference-of-four_dof
reference-design: reference-of-design
.PHONY: $(STUDIES:%=reference-of-%)
$(STUDIES:%=reference-of-%): reference-of-%: $(DEV)
	$(BIN)/gantry-tau study configs/studies/$*.yaml --out results/$*
	mkdir -p results/reference/$*
	cp results/$*/study.csv results/reference/$*/
	$(BIN)/python -m tests.benchmarks.$* results/reference/$*/study.csv results/reference/$*/$*.png

# The notebooks as .ipynb files with their outputs, for Jupyter, VS Code or a browser: a minute.
.PHONY: notebooks
notebooks: $(DEV)
	$(BIN)/jupytext --quiet --to ipynb notebooks/*.py
	$(BIN)/jupyter execute --inplace notebooks/*.ipynb

# The documentation as HTML in build/docs: half a minute. Every warning is an error, internal links included.
.PHONY: docs docs-tools
docs: $(VENV)/.docs.ready
	$(BIN)/sphinx-build --fail-on-warning --keep-going --nitpicky --quiet --fresh-env docs build/docs

docs-tools: $(VENV)/.docs.ready

# Seconds and memory of stage one, alone and beside other solvers: about a quarter of an hour on a quiet machine.
.PHONY: bench
bench: $(DEV) $(VENV)/.bench.ready bench-runs
	$(BIN)/python -m tests.benchmarks $(ARGS)

# Whole runs, medians of five: a file per date in results/benchmarks/history, and a plot over dates: five minutes. In turns
# with another checkout: make bench-runs RUNS_ARGS="--tree DIR".
.PHONY: bench-runs bench-setup
bench-runs: $(DEV)
	$(BIN)/python -m tests.benchmarks.whole_runs $(RUNS_ARGS)

# The set-up of `make run` from nothing beside that with pip and all that development needs: ten minutes.
bench-setup: $(DEV)
	$(BIN)/python -m tests.benchmarks.setting_up

# Stage two: meshes, other solvers and formulations, random tasks and machines: ten minutes. Then the motions of the
# defaults before and after, on fixed tasks and random machines: twenty.
.PHONY: bench-refine
bench-refine: $(DEV)
	$(BIN)/python -m tests.benchmarks.refining $(ARGS)
	$(BIN)/python -m tests.benchmarks.refining_motion

# Stage three: grids, lower bound, limited jerk, and what one would use instead; proofs of 20 random motions: ten minutes.
.PHONY: bench-retime
bench-retime: $(DEV) $(VENV)/.bench.ready
	$(BIN)/python -m tests.benchmarks.retiming $(ARGS)
	$(BIN)/python -m tests.benchmarks.proving

# Programs that read what is exported, for the tests of exports; LinuxCNC comes with apt-get install linuxcnc-uspace.
.PHONY: consumers
consumers: $(VENV)/.consumers.ready

# The twin: its speed, MuJoCo beside it, stiffness against gravity, and 25 random machines and tasks: twenty minutes.
.PHONY: bench-simulate
bench-simulate: $(DEV)
	$(BIN)/python -m tests.benchmarks.simulating $(ARGS)

# Bodies: 20 random tasks with obstacles, checked by coal where `make consumers` has brought it, and what bodies cost in
# turns with a checkout from before them (ARGS="--tree DIR"): an hour on a quiet machine.
.PHONY: bench-bodies
bench-bodies: $(DEV)
	$(BIN)/python -m tests.benchmarks.bodies $(ARGS)

# Studies: throughput and overheads, then 25 kills of client, scheduler and workers: ten minutes.
.PHONY: bench-study
bench-study: $(DEV)
	$(BIN)/python -m tests.benchmarks.studying $(ARGS)
	$(BIN)/python -m tests.benchmarks.study_kills --kills 25

# The source distribution, and the wheel built from it.
.PHONY: dist
dist: $(DEV)
	rm -rf build/dist
	$(BIN)/python -m build --outdir build/dist

# A software bill of materials (CycloneDX) of what a run needs, from an environment that holds nothing else.
.PHONY: sbom
sbom: $(VENV)/.release.ready
	rm -rf build/sbom
	$(PYTHON) -m venv --without-pip build/sbom/venv
	$(call install,build/sbom/venv/bin/python,.)
	$(BIN)/cyclonedx-py environment --pyproject pyproject.toml --mc-type application --output-reproducible \
		--output-file build/sbom/gantry-tau.cdx.json build/sbom/venv/bin/python

# How the repository compares with what the Scientific Python community advises; answers are in pyproject.toml.
.PHONY: review
review: $(VENV)/.release.ready
	$(BIN)/sp-repo-review .

# Installs for the Python $(1) what $(2) says: with uv, in a third of the time; with pip where uv cannot be had, or fails.
define install
	@( [ -x $(BIN)/uv ] && $(BIN)/uv pip install --quiet --compile-bytecode --python $(1) --constraint constraints.txt $(2) ) || \
	$(BIN)/python -m pip --python $(1) install --quiet --disable-pip-version-check --constraint constraints.txt $(2)
endef

# A marker says that a set was installed to its end. An installation that was not may have left half a package, which
# installers take for a whole one: everything is then begun again.
PART := $(VENV)/.installing
ifneq ($(wildcard $(PART)),)
$(shell rm -f $(VENV)/.*.ready)
endif

$(VENV)/.venv.ready:
	$(PYTHON) -m venv --clear $(VENV)
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt uv || \
		echo "uv could not be had: pip installs the rest, which takes longer" >&2
	@touch $@

$(RUN): pyproject.toml constraints.txt | $(VENV)/.venv.ready
	@touch $(PART)
	$(call install,$(BIN)/python,--editable .)
	@rm $(PART)
	@touch $@

# Sets for other work bring what a run needs.
$(VENV)/.%.ready: pyproject.toml constraints.txt | $(VENV)/.venv.ready
	@touch $(PART)
	$(call install,$(BIN)/python,--editable ".[$*]")
	@rm $(PART)
	@touch $(RUN) $@

clean:
	rm -rf $(VENV) build .mypy_cache .ruff_cache .pytest_cache .hypothesis .coverage*
