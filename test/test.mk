# Every test: faults, unit tests on the host and on the simulated AVR, whole runs.

# Without sanitizers: a whole run is some hundred thousand exchanges.
FAULTS_BOARDS := atmega128 arduino-uno arbotix
FAULTS_SRC := $(wildcard test/faults/*.c)
FAULTS_NEEDS := build/host/faults $(FAULTS_BOARDS:%=build/%/program/exchanges.elf) \
	build/atmega128/controller.elf build/arbotix/controller.elf

build/host/faults-obj/%.o: test/faults/%.c build/host/flags | tools
	$(call say,CC,$@)
	@mkdir -p $(@D)
	$(Q)$(CC) $(SIM_FLAGS) $(INCLUDES) -O2 $(DEPFILES) -c $< -o $@

build/host/faults: $(FAULTS_SRC:test/faults/%.c=build/host/faults-obj/%.o) \
		$(patsubst sim/%.c,build/host/sim/%.o,$(filter-out sim/main.c,$(SIM_SRC)))
	$(call say,LD,$@)
	$(Q)$(CC) $^ $(SIM_LIBS) -o $@

FAULTS_PART ?= 1/1
SEED ?= 0

## faults: every fault of docs/faults.md at every position; build/faults.tsv (FAULTS_PART=1/20 SEED=7)
.PHONY: faults
faults: $(FAULTS_NEEDS)
	@scripts/faults.py --part $(FAULTS_PART) --seed $(SEED)

## faults-docs: the same, and its table in docs/faults.md anew
.PHONY: faults-docs
faults-docs: faults
	@scripts/faults.py --docs

# ---- tests -----------------------------------------------------------------------------------------

UNITY_FLAGS := -I$(UNITY)/src -DUNITY_INCLUDE_CONFIG_H -Itest

# Unity is not ours: no warnings of ours for it. deps has fetched it.
$(UNITY)/src/unity.c $(UNITY)/auto/generate_test_runner.rb: | deps ;

CORE_TESTS := $(patsubst test/%.c,%,$(wildcard test/test_*.c))
SIM_TESTS := $(patsubst test/sim/%.c,%,$(wildcard test/sim/test_*.c))
RUN_TESTS := $(wildcard test/run/test_*.py)
TEST_FIRMWARES := $(patsubst test/firmware/%.c,%,$(wildcard test/firmware/*.c))

build/runner/%_runner.c: test/%.c $(UNITY)/auto/generate_test_runner.rb
	@mkdir -p $(@D)
	$(Q)ruby $(UNITY)/auto/generate_test_runner.rb $< $@

build/runner/sim/%_runner.c: test/sim/%.c $(UNITY)/auto/generate_test_runner.rb
	@mkdir -p $(@D)
	$(Q)ruby $(UNITY)/auto/generate_test_runner.rb $< $@

# On the host, under AddressSanitizer and UBSan.
HOST_TEST_FLAGS := $(HOST_COMMON) $(SANITIZE) $(INCLUDES) -Isrc/controller -Isim $(UNITY_FLAGS)

build/host/test/flags: force
	$(call stamp,$(CC) $(HOST_TEST_FLAGS))

build/host/test/obj/%.o: %.c build/host/test/flags | deps
	$(call say,CC,$@)
	@mkdir -p $(@D)
	$(Q)$(CC) $(HOST_TEST_FLAGS) $(DEPFILES) -c $< -o $@

build/host/test/obj/runner/%.o: build/runner/%.c build/host/test/flags
	@mkdir -p $(@D)
	$(Q)$(CC) $(HOST_TEST_FLAGS) -Wno-error $(DEPFILES) -c $< -o $@

build/host/test/obj/unity.o: $(UNITY)/src/unity.c build/host/test/flags
	@mkdir -p $(@D)
	$(Q)$(CC) $(HOST_TEST_FLAGS) -w $(DEPFILES) -c $< -o $@

# What a test of the core or of the console is linked with.
TESTED_SRC := $(CORE_SRC) $(filter-out src/controller/main.c,$(CONTROLLER_SRC)) test/port_fake.c \
	test/eeprom_fake.c
# CORE_ONLY=1: the programs that include nothing of src/controller, linked without it.
CONTROLLER_TESTS := $(addprefix test_,bridge cmd_keeper command console editor host host_rescue keeper \
	number robot settings) fuzz inhibit_random
ifeq ($(CORE_ONLY),1)
TESTED_SRC := $(CORE_SRC) test/port_fake.c
endif
TESTED_OBJ := $(TESTED_SRC:%.c=build/host/test/obj/%.o) build/host/test/obj/unity.o

$(CORE_TESTS:%=build/host/test/%): build/host/test/%: build/host/test/obj/test/%.o \
		build/host/test/obj/runner/%_runner.o $(TESTED_OBJ)
	$(call say,LD,$@)
	$(Q)$(CC) $(SANITIZE) $^ -o $@

RANDOM_TESTS := fuzz inhibit_random engine_random door_random
$(RANDOM_TESTS:%=build/host/test/%): build/host/test/%: build/host/test/obj/test/%.o $(TESTED_OBJ)
	$(call say,LD,$@)
	$(Q)$(CC) $(SANITIZE) $(filter-out %/unity.o,$^) -o $@

$(SIM_TESTS:%=build/host/test/sim/%): build/host/test/sim/%: build/host/test/obj/test/sim/%.o \
		build/host/test/obj/runner/sim/%_runner.o build/host/test/obj/unity.o \
		$(patsubst sim/%.c,build/host/sim-checked/%.o,$(filter-out sim/main.c,$(SIM_SRC)))
	$(call say,LD,$@)
	@mkdir -p $(@D)
	$(Q)$(CC) $(SANITIZE) $^ $(SIM_LIBS) -o $@

# The same suites on the simulated AVR.
AVR_TEST_BOARD := arduino-mega
AVR_TEST := build/avr-test
AVR_TEST_FLAGS = $(filter-out -flto -ffat-lto-objects -gdwarf-2,$($(AVR_TEST_BOARD)_FLAGS)) \
	-UBOARD_NAME -Isrc/controller $(UNITY_FLAGS)

$(AVR_TEST)/flags: force
	$(call stamp,$(AVR_TEST_FLAGS))

$(AVR_TEST)/obj/%.o: %.c $(AVR_TEST)/flags | deps
	$(call say,CC,$@)
	@mkdir -p $(@D)
	$(Q)$(AVR_CC) $(AVR_TEST_FLAGS) $(DEPFILES) -c $< -o $@

$(AVR_TEST)/obj/runner/%.o: build/runner/%.c $(AVR_TEST)/flags
	@mkdir -p $(@D)
	$(Q)$(AVR_CC) $(AVR_TEST_FLAGS) -Wno-error $(DEPFILES) -c $< -o $@

$(AVR_TEST)/obj/unity.o: $(UNITY)/src/unity.c $(AVR_TEST)/flags
	@mkdir -p $(@D)
	$(Q)$(AVR_CC) $(AVR_TEST_FLAGS) -w $(DEPFILES) -c $< -o $@

$(CORE_TESTS:%=$(AVR_TEST)/%.elf): $(AVR_TEST)/%.elf: $(AVR_TEST)/obj/test/%.o \
		$(AVR_TEST)/obj/runner/%_runner.o $(TESTED_SRC:%.c=$(AVR_TEST)/obj/%.o) \
		$(AVR_TEST)/obj/test/unity_avr.o $(AVR_TEST)/obj/unity.o
	$(call say,LD,$@)
	$(Q)$(AVR_CC) $(AVR_TEST_FLAGS) $(AVR_LINK) $^ -o $@

PROGRAM_SRC := $(filter-out test/program/three_buses.c,$(wildcard test/program/*.c))

# Small firmwares for tests of the simulator: plain register code, nothing of ours linked.
FIRMWARE_MCU := atmega128
build/firmware/three_buses.elf: FIRMWARE_MCU := atmega2560
build/firmware/%.elf: test/firmware/%.c build/atmega128/flags | tools
	$(call say,CC,$@)
	@mkdir -p $(@D)
	$(Q)$(AVR_CC) -mmcu=$(FIRMWARE_MCU) -DF_CPU=16000000UL -std=gnu99 -Os $(WARNINGS) $(DEPFILES) $< -o $@

TEST_PROGRAMS := $(CORE_TESTS:%=build/host/test/%) $(CORE_TESTS:%=$(AVR_TEST)/%.elf) \
	$(SIM_TESTS:%=build/host/test/sim/%)
TEST_NEEDS := build/host/cds55xx-sim $(PROGRAM_SRC:test/program/%.c=build/atmega128/program/%.elf) $(RANDOM_TESTS:%=build/host/test/%) \
	$(TEST_FIRMWARES:%=build/firmware/%.elf) \
	build/arduino-mega/program/three_buses.elf $(foreach p,commands operations,$(BOARDS:%=build/%/program/$(p).elf)) \
	build/arbotix/program/soak.elf build/arbotix/program/foreign_handler.elf \
	$(patsubst %,build/%/program/safety.elf,arduino-mega arbotix cm510) \
	$(patsubst %,build/%/program/flood.elf,arduino-mega cm510 arbotix) \
	build/adapter-echo/program/diagnose.elf build/arbotix/program/diagnose.elf \
	$(TEST_BOARDS:%=build/%/controller.elf) $(TEST_BOARDS:%=build/%/program/soak.elf) \
	$(FAULTS_NEEDS) $(BENCH_NEEDS) \
	$(patsubst %,build/atmega128/bench/%.elf,slow_handlers blocking_absent) \
	$(BOARDS:%=build/%/controller.elf) $(EXAMPLES)

## test: every test: on the host, on the simulated AVR, and whole runs in the simulator
.PHONY: test
test: $(TEST_PROGRAMS) $(TEST_NEEDS)
	@SIM=build/host/cds55xx-sim FIRMWARE=build/firmware scripts/run-tests.py \
	  --avr-board $(AVR_TEST_BOARD) $(TEST_PROGRAMS) $(RUN_TESTS)

# The programs on this machine that run src/core. The scripts build them with flags of their own.
HOST_TESTS := $(patsubst %,build/host/test/%,$(filter-out $(if $(filter 1,$(CORE_ONLY)),$(CONTROLLER_TESTS)), \
	$(CORE_TESTS) $(RANDOM_TESTS)))
.PHONY: host-tests list-host-tests
host-tests: $(HOST_TESTS)
list-host-tests:
	@printf '%s\n' $(HOST_TESTS)

## coverage: branch coverage of src/core by the tests on the host; fails below COVERAGE_LIMIT percent
COVERAGE_LIMIT ?= 98
.PHONY: coverage
coverage: | deps
	@scripts/coverage.py --limit $(COVERAGE_LIMIT)

## mutation: mutants of src/core that the tests on the host notice; fails below MUTATION_LIMIT percent
MUTATION_LIMIT ?= 93
MUTANTS ?= 300
.PHONY: mutation
mutation: | deps
	@scripts/mutation.py --count $(MUTANTS) --limit $(MUTATION_LIMIT)

## cycle: 60 s of 50 servos at 250 Hz: the figures; fails if a promise is broken
.PHONY: cycle
cycle: build/host/cds55xx-sim build/atmega128/program/cycle50.elf
	@test/run/cycle.py 60

## fuzz: random bytes, damaged lines and packets for the host link; random input while inhibited; random transactions
.PHONY: fuzz
fuzz: $(RANDOM_TESTS:%=build/host/test/%)
	@build/host/test/fuzz 10000000 1000000
	@build/host/test/inhibit_random 1000000
	@build/host/test/engine_random 10000000

## session: a first session with the console of an atmega128, as it stands on the terminal
.PHONY: session
session: build/host/cds55xx-sim build/atmega128/controller.elf
	@scripts/console.py --session

## feedback: 18 servos' feedback over a 1 Mbps host link: one BULK READ against 18 round trips
.PHONY: feedback
feedback: build/host/cds55xx-sim build/$(BOARD)/controller.elf
	@test/run/feedback.py $(BOARD)

