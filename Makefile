# Needs Python 3.11 to 3.14, make and git. Every target that runs something builds .venv first.
#
#   make test ARGS="-k frame"     passes arguments on to what the target runs

.DEFAULT_GOAL := help
.PHONY: help ready demo docs kernels test test-slow check bench clean

ARGS =
BIN = .venv/bin
# nproc takes OMP_NUM_THREADS for the number of cores.
WORKERS = $(shell n=$$(env -u OMP_NUM_THREADS nproc 2>/dev/null || echo 2); echo $$((n < 2 ? 2 : n)))
IN_RANGE = import sys; sys.exit(not (3, 11) <= sys.version_info < (3, 15))
PYTHON = $(shell for python in python3 python3.14 python3.13 python3.12 python3.11; do \
	if $$python -c '$(IN_RANGE)' 2>/dev/null; then echo $$python; break; fi; done)

help: ## list the targets
	@awk -F ':.*## ' '/^[a-z-]+:.*## / {printf "  make %-10s %s\n", $$1, $$2}' $(MAKEFILE_LIST)

demo: ready ## let a simulated robot clear a table; report and film go to out/demo
	@$(BIN)/eyehand demo $(ARGS)

docs: ready ## build the documentation site in out/site
	@NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --strict --quiet $(ARGS)
	@echo "open out/site/index.html"

kernels: ready ## compile the kernels that a pick uses (once, one to two minutes)
	@$(BIN)/python -c \
		"from eyehand.apps.grasp.warm_up import warm_up_grasping as w; w(jaws=True)"

# One thread per worker: the workers already fill the cores.
test test-slow: export OMP_NUM_THREADS = 1
test test-slow: export OPENBLAS_NUM_THREADS = 1
# With worksteal, a worker runs neighbouring tests, which share fixtures, and none is idle at the end.
test: ready ## run the tests without the slow ones, in one process per core
	@$(BIN)/pytest -n $(WORKERS) --dist worksteal -m "not slow" $(ARGS)

test-slow: ready ## run the slow tests: whole stress sweeps and long trials
	@$(BIN)/pytest -n $(WORKERS) --dist worksteal -m slow $(ARGS)

check: ready ## lint, formatting and types
	@$(BIN)/ruff check
	@$(BIN)/ruff format --check
	@$(BIN)/pyright

bench: export OPENBLAS_NUM_THREADS = 1
bench: ready ## time what has a benchmark
	@$(BIN)/pytest --benchmark-enable --benchmark-only -q -r N $(ARGS)

clean: ## remove .venv, .uv, caches and build folders (results in out/ stay)
	@rm -rf .venv .uv build dist *.egg-info .pytest_cache .ruff_cache .hypothesis .benchmarks
	@find . -name __pycache__ -type d -prune -exec rm -rf {} +

ready:
	@python=$(PYTHON); if [ -z "$$python" ]; then \
		echo "eyehand: needs Python 3.11 to 3.14 on PATH, found only" \
			"$$(python3 --version 2>/dev/null || echo none); install python3.12, say" >&2; exit 1; fi; \
	$$python .ci/bootstrap.py
