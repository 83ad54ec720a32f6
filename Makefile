# `make bench` and `make test` are the two commands; each sets up what it lacks (.ci/setup says what, and why).
.DEFAULT_GOAL := help
.PHONY: help setup bench test clean
export PATH := $(PATH):$(HOME)/.cargo/bin

help: ## list the targets
	@sed -nE 's/^([a-z]+):.*## (.*)/  make \1@\2/p' Makefile | tr @ '\t' | expand -t 15

setup: ## install what `make bench` and `make test` need and this machine lacks
	@.ci/setup bench
	@.ci/setup test

bench: ## build, trace, check and time the default scenes on the best device; ARGS= goes to `boxwood bench`
	@.ci/setup bench
	cargo build --release --locked
	$(or $(CARGO_TARGET_DIR),target)/release/boxwood bench $(ARGS)

test: ## format, lints, docs, and every test on lavapipe; ARGS= goes to the test binaries
	@.ci/setup test
	@.ci/test $(ARGS)

clean: ## remove what cargo built; the merged shaderc stays, in .boxwood
	cargo clean
