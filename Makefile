.DEFAULT_GOAL := help
.PHONY: help setup demo demo-iea demo-reduced demo-set quick test test-all attack lint docs reference gallery verification bench bench-peers clean
# Where things are installed, and results go; both may lie outside of the checkout.
export VENV ?= .venv
OUT ?= out
export OMP_NUM_THREADS ?= 1
export OPENBLAS_NUM_THREADS ?= 1

help: ## show this list
	@sed -n 's/^\([a-z-]*\):.*## /  make \1\t/p' Makefile

setup: ## install what is missing, make .venv
	@scripts/setup.sh

demo: setup ## run the stiff hybrid turbine of the paper into out/hybrid_stiff
	$(VENV)/bin/turbine-fenicsx run demos/paper/hybrid_stiff.toml -o $(OUT)/hybrid_stiff --overwrite

demo-iea: setup ## run the IEA 15 MW turbine for ten seconds into out/iea15 and draw it with the failure of its plies
	$(VENV)/bin/turbine-fenicsx run demos/iea15/iea15.toml -o $(OUT)/iea15 --overwrite
	$(VENV)/bin/turbine-fenicsx render $(OUT)/iea15 --times 4,7,10 --field tsai_wu -o $(OUT)/iea15
	$(VENV)/bin/turbine-fenicsx render $(OUT)/iea15 --movie $(OUT)/iea15/movie.mp4 --field tsai_wu

demo-reduced: setup ## run ten minutes of turbulence with reduced blades into out/turbulence and draw power, pitch, loads, clearance, failure of plies
	mkdir -p $(OUT)/turbulence
	cp demos/turbulence/turbulence.toml $(OUT)/turbulence
	$(VENV)/bin/turbine-fenicsx run $(OUT)/turbulence/turbulence.toml -o $(OUT)/turbulence/run --overwrite
	$(VENV)/bin/turbine-fenicsx recover $(OUT)/turbulence/run --overwrite
	$(VENV)/bin/python demos/turbulence/draw.py $(OUT)/turbulence/run

demo-set: setup ## run power production of the IEA 15 MW turbine with rigid blades at all winds into out/load_set and write its report
	mkdir -p $(OUT)/load_set
	cp demos/load_set/*.toml $(OUT)/load_set
	$(VENV)/bin/turbine-fenicsx dlc $(OUT)/load_set/set.toml -o $(OUT)/load_set/runs
	$(VENV)/bin/turbine-fenicsx report $(OUT)/load_set/runs

# The tests of formulas, without those that compile the forms of every material and cell.
FORMULAS = tests/test_layers.py tests/test_language.py $(addprefix tests/unit/,foundation materials bodies joints forces system) \
    --ignore-glob='*/test_flexible_*.py' --ignore-glob='*/test_cell_fields.py'
quick: lint ## before every commit: ruff, mypy, tests of formulas on one rank; below two minutes
	$(VENV)/bin/python -m pytest -q -n 2 --dist worksteal $(FORMULAS)

test: setup ## run the tests without the slow ones on 1 rank, the parallel ones on 2 ranks too
	scripts/test.sh

test-all: setup ## the same with the slow ones
	scripts/test.sh --all

attack: setup ## damaged files and killed processes at full size, hours; ATTACK=... chooses
	$(VENV)/bin/python -m tests.attack $(ATTACK)

lint: setup ## ruff and mypy
	$(VENV)/bin/ruff check .
	$(VENV)/bin/ruff format --check .
	$(VENV)/bin/mypy turbine_fenicsx

docs: setup ## build docs/_build/html, the documentation; warnings are errors
	@$(VENV)/bin/python -c 'import sphinx, myst_parser, pydata_sphinx_theme; __import__("sphinx-mathjax-offline")' \
	    2>/dev/null || { echo "docs: Python packages [docs]"; $(VENV)/bin/python -m pip install -q \
	    --disable-pip-version-check -c $(VENV)/constraints.txt -e '.[docs]'; }
	$(VENV)/bin/python -m sphinx -q -E -W --keep-going -n -b html docs docs/_build/html
	@echo "docs: $(CURDIR)/docs/_build/html/index.html"

reference: setup ## write the tables of docs/reference anew: keys of case files, commands, public names
	$(VENV)/bin/python docs/_extensions/generated.py

gallery: setup ## run all demos and draw docs/gallery.md and the README's pictures, some twenty minutes
	$(VENV)/bin/python demos/gallery

verification: setup ## run the published benchmarks and write docs/verification.md, some minutes
	$(VENV)/bin/python demos/verification

bench: setup ## run the benchmark into benchmarks/out, about two hours
	$(VENV)/bin/python benchmarks/run.py

bench-peers: ## install CalculiX, NGSolve, Kratos and Exudyn to compare with
	benchmarks/install_peers.sh

clean: ## remove .venv, build and caches, but not out
	rm -rf .venv build docs/_build *.egg-info .pytest_cache .ruff_cache .mypy_cache
	find . -name __pycache__ -prune -exec rm -rf {} +
