# SPDX-License-Identifier: MIT
# Every test: faults, unit tests on the host and on the simulated AVR, whole runs.

FAULTS_BOARDS := atmega128 arduino-uno arbotix
FAULTS_SRC := $(wildcard test/faults/*.c)
FAULTS_NEEDS := build/host/faults $(FAULTS_BOARDS:%=build/%/firmware/transactions.elf) \
	build/atmega128/controller.elf build/arbotix/controller.elf

# Without sanitizers: a whole run has some hundred thousand transactions.
build/host/faults-obj/%.o: test/faults/%.c build/host/flags | tools
	$(call say,CC,$@)
	$(call folder,$(@D))
	$(Q)$(CC) $(SIM_FLAGS) $(INCLUDES) $(SIM_FAST) $(DEPFILES) -c $< -o $@

build/host/faults: $(FAULTS_SRC:test/faults/%.c=build/host/faults-obj/%.o) \
		$(patsubst sim/%.c,build/host/sim/%.o,$(filter-out sim/main.c,$(SIM_SRC)))
	$(call say,LD,$@)
	$(Q)$(CC) $(SIM_FAST) $^ $(SIM_LIBS) -o $@

# For scripts/faults.py.
.PHONY: list-faults-boards
list-faults-boards:
	@printf '%s\n' $(FAULTS_BOARDS)

FAULTS_PART ?= 1/1
SEED ?= 0

## faults: every fault of docs/internals/faults.md at every position; build/faults.tsv (FAULTS_PART=1/20 SEED=7 ROWS=F16)
.PHONY: faults
faults: $(FAULTS_NEEDS)
	$(clear)
	@scripts/faults.py --part $(FAULTS_PART) --seed $(SEED) $(ROWS)

# Before the run, which takes long.
ifneq ($(filter faults-docs,$(MAKECMDGOALS)),)
ifneq ($(ROWS)$(filter-out 1/1,$(FAULTS_PART)),)
$(error make faults-docs renews the whole table: leave out $(if $(ROWS),ROWS,FAULTS_PART))
endif
endif

## faults-docs: make faults, and renew its table in docs/internals/faults.md
.PHONY: faults-docs
faults-docs: faults
	@scripts/faults.py --docs

# ---- tests -----------------------------------------------------------------------------------------

UNITY_FLAGS := -I$(UNITY)/src -DUNITY_INCLUDE_CONFIG_H -Itest/support

# Unity comes from its authors, so this project's warnings are off for it. The target deps fetches it.
$(UNITY)/src/unity.c $(UNITY)/auto/generate_test_runner.rb: | deps ;

# A suite is test/<part>/<folder>/test_X.c. It becomes build/host/test/test_X, and on the simulated
# AVR build/avr-test/test_X.elf. The name of each suite must be unique: all programs go into one folder.
CORE_TEST_SRC := $(wildcard test/core/*/test_*.c)
CONTROLLER_TEST_SRC := $(wildcard test/controller/*/test_*.c)
UNIT_TEST_SRC := $(CORE_TEST_SRC) $(CONTROLLER_TEST_SRC)
SIM_TEST_SRC := $(wildcard test/sim/test_*.c)
# Programs without Unity that take a number of random inputs.
CORE_RANDOM_SRC := $(wildcard test/core/*/*_random.c)
CONTROLLER_RANDOM_SRC := $(wildcard test/controller/*/*_random.c test/controller/*/fuzz.c)
RANDOM_SRC := $(CORE_RANDOM_SRC) $(CONTROLLER_RANDOM_SRC)

host_program = $(patsubst %,build/host/test/%,$(basename $(notdir $(1))))

build/runner/test/%_runner.c: test/%.c $(UNITY)/auto/generate_test_runner.rb
	$(call folder,$(@D))
	$(Q)ruby $(UNITY)/auto/generate_test_runner.rb $< $@

# On the host, under AddressSanitizer and UBSan.
HOST_TEST_FLAGS := $(HOST_COMMON) $(SANITIZE) $(INCLUDES) -Isrc/controller -Isim $(UNITY_FLAGS)

build/host/test/flags: force
	$(call stamp,$(CC) $(HOST_TEST_FLAGS))

build/host/test/obj/%.o: %.c build/host/test/flags | deps
	$(call say,CC,$@)
	$(call folder,$(@D))
	$(Q)$(CC) $(HOST_TEST_FLAGS) $(DEPFILES) -c $< -o $@

build/host/test/obj/%_runner.o: build/runner/%_runner.c build/host/test/flags
	$(call folder,$(@D))
	$(Q)$(CC) $(HOST_TEST_FLAGS) -I$(patsubst build/runner/%/,%,$(dir $<)) -Wno-error $(DEPFILES) -c $< -o $@

build/host/test/obj/unity.o: $(UNITY)/src/unity.c build/host/test/flags
	$(call folder,$(@D))
	$(Q)$(CC) $(HOST_TEST_FLAGS) -w $(DEPFILES) -c $< -o $@

# Archives for the suites: a suite of the core links the core, a suite of the controller links both.
CORE_TESTED := $(CORE_SRC) test/support/port_fake.c
CONTROLLER_TESTED := $(filter-out src/controller/main.c,$(CONTROLLER_SRC)) test/support/board_fake.c test/support/eeprom_fake.c

build/host/test/libcore.a: $(CORE_TESTED:%.c=build/host/test/obj/%.o) build/host/test/obj/unity.o
build/host/test/libcontroller.a: $(CONTROLLER_TESTED:%.c=build/host/test/obj/%.o)
build/host/test/libcore.a build/host/test/libcontroller.a:
	$(call say,AR,$@)
	$(Q)rm -f $@ && ar rcs $@ $^

# $(1): source of a suite, $(2): folder of the archives
tested_by = $(if $(filter test/controller/%,$(1)),$(2)/libcontroller.a) $(2)/libcore.a

build/host/test/libsim.a: $(patsubst sim/%.c,build/host/sim-checked/%.o,$(filter-out sim/main.c,$(SIM_SRC))) \
		build/host/test/obj/unity.o
	$(call say,AR,$@)
	$(Q)rm -f $@ && ar rcs $@ $^

# $(1): source, $(2): program, $(3): libraries
define host_test_rule
$(2): build/host/test/obj/$(1:%.c=%.o) $(if $(filter test_%,$(notdir $(1))),build/host/test/obj/$(1:%.c=%_runner.o)) $(3)
	$$(call say,LD,$$@)
	$$(call folder,$$(@D))
	$$(Q)$$(CC) $$(SANITIZE) $$(filter %.o %.a,$$^) $(4) -o $$@
endef
$(foreach s,$(UNIT_TEST_SRC) $(RANDOM_SRC),$(eval $(call host_test_rule,$(s),$(call \
	host_program,$(s)),$(call tested_by,$(s),build/host/test))))
$(foreach s,$(SIM_TEST_SRC),$(eval $(call host_test_rule,$(s),$(s:%.c=build/host/%),build/host/test/libsim.a,$(SIM_LIBS))))

# The same suites on the simulated AVR.
AVR_TEST_BOARD := arduino-mega
AVR_TEST := build/avr-test
AVR_TEST_FLAGS = $(filter-out -flto -ffat-lto-objects -gdwarf-2,$($(AVR_TEST_BOARD)_FLAGS)) \
	-UBOARD_NAME -Isrc/controller $(UNITY_FLAGS)

$(AVR_TEST)/flags: force
	$(call stamp,$(AVR_TEST_FLAGS))

$(AVR_TEST)/obj/%.o: %.c $(AVR_TEST)/flags | deps
	$(call say,CC,$@)
	$(call folder,$(@D))
	$(Q)$(AVR_CC) $(AVR_TEST_FLAGS) $(DEPFILES) -c $< -o $@

$(AVR_TEST)/obj/%_runner.o: build/runner/%_runner.c $(AVR_TEST)/flags
	$(call folder,$(@D))
	$(Q)$(AVR_CC) $(AVR_TEST_FLAGS) -I$(patsubst build/runner/%/,%,$(dir $<)) -Wno-error $(DEPFILES) -c $< -o $@

$(AVR_TEST)/obj/unity.o: $(UNITY)/src/unity.c $(AVR_TEST)/flags
	$(call folder,$(@D))
	$(Q)$(AVR_CC) $(AVR_TEST_FLAGS) -w $(DEPFILES) -c $< -o $@

$(AVR_TEST)/libcore.a: $(CORE_TESTED:%.c=$(AVR_TEST)/obj/%.o) $(AVR_TEST)/obj/test/support/unity_avr.o $(AVR_TEST)/obj/unity.o
$(AVR_TEST)/libcontroller.a: $(CONTROLLER_TESTED:%.c=$(AVR_TEST)/obj/%.o)
$(AVR_TEST)/libcore.a $(AVR_TEST)/libcontroller.a:
	$(call say,AR,$@)
	$(Q)rm -f $@ && $(AVR_AR) rcs $@ $^

define avr_test_rule
$(AVR_TEST)/$(basename $(notdir $(1))).elf: $(AVR_TEST)/obj/$(1:%.c=%.o) $(AVR_TEST)/obj/$(1:%.c=%_runner.o) $(call tested_by,$(1),$(AVR_TEST))
	$$(call say,LD,$$@)
	$$(Q)$$(AVR_CC) $$(AVR_TEST_FLAGS) $$(AVR_LINK) $$(filter %.o %.a,$$^) -o $$@
endef
$(foreach s,$(UNIT_TEST_SRC),$(eval $(call avr_test_rule,$(s))))

# Small firmwares for tests of the simulator: plain register code without the library.
FIRMWARE_MCU := atmega128
build/firmware/three_buses.elf: FIRMWARE_MCU := atmega2560
build/firmware/%.elf: test/firmware/registers/%.c build/atmega128/flags | tools
	$(call say,CC,$@)
	$(call folder,$(@D))
	$(Q)$(AVR_CC) -mmcu=$(FIRMWARE_MCU) -DF_CPU=16000000UL -std=gnu99 -Os $(WARNINGS) $(DEPFILES) $< -o $@

RANDOM_TESTS := $(call host_program,$(RANDOM_SRC))
SIM_TEST_ELFS := $(patsubst test/firmware/registers/%.c,build/firmware/%.elf,$(wildcard test/firmware/registers/*.c))

UNIT_TESTS := $(call host_program,$(UNIT_TEST_SRC)) \
	$(patsubst %,$(AVR_TEST)/%.elf,$(basename $(notdir $(UNIT_TEST_SRC))))
SIM_TESTS := $(SIM_TEST_SRC:%.c=build/host/%)
# make test-long runs these suites in full length; make test runs them, first, with fewer random inputs; CI runs one
# of four parts in full length (is_long() of test/runs/simulator.py).
LONG_SUITES := autostart bridge bus_random console_commands diagnose example_hexapod example_robot example_teach failsafe \
	faults_all firmware flood fuzz identity inhibit permit_random
LONG_TESTS := $(LONG_SUITES:%=test/runs/test_%.py)
ALL_RUN_TESTS := $(wildcard test/runs/test_*.py)
ifneq ($(filter-out $(ALL_RUN_TESTS),$(LONG_TESTS)),)
$(error LONG_SUITES of test/test.mk names $(filter-out $(ALL_RUN_TESTS),$(LONG_TESTS)), which does not exist)
endif
RUN_TESTS := $(LONG_TESTS) $(filter-out $(LONG_TESTS),$(ALL_RUN_TESTS))

# Boards with a host link. test/runs/boards.py has the same list for the runs.
HOST_BOARDS := $(foreach b,$(BOARDS),$(if $($(b)_PROFILE),$(b)))
CONSOLE_ELFS := $(HOST_BOARDS:%=build/%/controller.elf)
PROFILE_ELFS := $(foreach b,$(HOST_BOARDS),$(call profile_elfs,$(b)))
# Each run names in a line `# needs: FILE ...` the files that must be built for it.
run_needs = $(if $(1),build/host/cds55xx-sim $(eval NEEDED := $(shell sed -n 's/^# needs: //p' $(1)))$(NEEDED))

# T=word: only the suites whose name contains the word; with several words, any of them.
T ?=
ALL_TESTS := $(UNIT_TESTS) $(SIM_TESTS) $(RUN_TESTS) $(if $(filter yes,$(PANEL)),$(PANEL_SUITES))
# $(1): word; $(2): suites. Returns the suites whose name contains the word.
tests_with = $(foreach t,$(2),$(if $(findstring $(1),$(basename $(notdir $(t)))),$(t)))
# $(1): suites. Returns those that T chooses.
chosen = $(if $(T),$(sort $(foreach w,$(T),$(call tests_with,$(w),$(1)))),$(1))
TESTS := $(call chosen,$(ALL_TESTS))
# The words that no suite has in its name.
UNKNOWN_WORDS := $(strip $(foreach w,$(T),$(if $(strip $(call tests_with,$(w),$(ALL_TESTS))),,$(w))))
test_programs = $(filter-out %.py %.js,$(TESTS)) $(if $(filter %.js,$(TESTS)),$(PANEL_NEEDS)) $(if $(filter $(SIM_TESTS),$(TESTS)),$(SIM_TEST_ELFS) build/host/cds55xx-sim) \
	$(if $(filter %/test_rules,$(TESTS)),$(patsubst %,build/%/controller.elf,arduino-mega cm510)) \
	$(if $(filter $(AVR_TEST)/%,$(TESTS)),build/host/cds55xx-sim) $(call run_needs,$(filter %.py,$(TESTS)))
run_tests = SIM=build/host/cds55xx-sim FIRMWARE=build/firmware scripts/run-tests.py \
	--avr-board $(AVR_TEST_BOARD)

## test: every test, or with T=word those whose name has the word: host, simulated AVR, whole runs
.PHONY: test
ifneq ($(UNKNOWN_WORDS),)
test:
	@echo "no suite has '$(firstword $(UNKNOWN_WORDS))' in its name; make list-tests lists the suites"; false
else
# If a profile does not fit the flash of a board, the suites that do not need it run, and the target fails.
.PHONY: test-programs fitting-tests
test-programs: $$(test_programs)
	@:
test:
	@$(MAKE) --no-print-directory test-programs || { ! ls build/*/*.over > /dev/null 2>&1 || \
	  $(MAKE) --no-print-directory fitting-tests; false; }
	$(clear)
	@$(run_tests) --times build/test-times.tsv $(TESTS) \
	  $(if $(T)$(filter yes,$(PANEL)),,--skipped "$(words $(PANEL_SUITES)) suites of the control panel; 'make test-panel' installs Chromium and runs them")
endif

# After test-programs has failed. UNFIT: the profiles that do not fit (scripts/link.sh), and copies of them.
ifneq ($(filter fitting-tests,$(MAKECMDGOALS)),)
UNFIT := $(foreach b,$(BOARDS),$(foreach p,$($(b)_PROFILES),$(if $(wildcard build/$(b)/$(p).over),build/$(b)/$(p).elf \
	$(if $(filter $(p),$($(b)_PROFILE)),build/$(b)/controller.elf))))
suite_needs = $(if $(filter %.py,$(1)),$(call run_needs,$(1)),$(if $(filter %.js,$(1)),$(PANEL_NEEDS)))
UNFIT_TESTS := $(foreach t,$(TESTS),$(if $(filter $(UNFIT),$(call suite_needs,$(t))),$(t)))
TESTS := $(filter-out $(UNFIT_TESTS),$(TESTS))
fitting-tests: $$(test_programs)
	$(clear)
	@$(if $(TESTS),$(run_tests) $(TESTS) || true)
	@for f in $(UNFIT:%.elf=%.over); do [ ! -e $$f ] || echo "$${f%.over} does not fit its flash, $$(cat $$f) bytes over: see 'Make room' in CONTRIBUTING.md"; done
	@echo 'not run, since they need a profile that does not fit: $(basename $(notdir $(UNFIT_TESTS)))'
endif

## list-tests: the names of the suites, for T=
.PHONY: list-tests
list-tests:
	@printf '%s\n' $(sort $(basename $(notdir $(ALL_TESTS))))

## test-long: the random and exhaustive runs in full length; make test runs them with fewer inputs
.PHONY: test-long
test-long: $$(call run_needs,$$(LONG_TESTS))
	$(clear)
	@TEST_LONG=1 $(run_tests) --times build/test-long-times.tsv $(LONG_TESTS)

ALL_BUILD_TESTS := $(wildcard test/build/test_*.py)
BUILD_TESTS := $(call chosen,$(ALL_BUILD_TESTS))
## test-build: what make itself promises: boards, flash, fuses, dependencies, checks; T=word as in test
.PHONY: test-build
test-build: $$(call run_needs,$$(BUILD_TESTS))
	@scripts/deps.sh test-build
	$(clear)
	$(if $(BUILD_TESTS),,@echo "no suite of test-build has '$(T)' in its name: $(notdir $(ALL_BUILD_TESTS))"; false)
	@$(run_tests) $(BUILD_TESTS)

# The programs on this machine that run src/core. Coverage and mutation build them with other flags.
HOST_TESTS := $(call host_program,$(UNIT_TEST_SRC) $(RANDOM_SRC))
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
cycle: build/host/cds55xx-sim build/atmega128/firmware/cycle50.elf
	$(clear)
	@test/runs/cycle.py 60

# For docs/library.md: simulates only if the program, the simulator or the run has changed.
build/cycle.txt: build/host/cds55xx-sim build/atmega128/firmware/cycle50.elf test/runs/cycle.py test/runs/simulator.py
	@test/runs/cycle.py 60 > $@.new || { cat $@.new; false; }
	@mv $@.new $@

.PHONY: cycle-quote
cycle-quote: build/cycle.txt
	@cat $<

## fuzz: random bytes, lines and packets for host link, inhibit, transactions and permit, millions of each
.PHONY: fuzz
fuzz: $(RANDOM_TESTS)
	$(clear)
	@build/host/test/fuzz 10000000 1000000
	@build/host/test/inhibit_random 1000000
	@build/host/test/bus_random 10000000
	@build/host/test/permit_random 1000000

## session: a first session with the console of an arduino-mega, as it stands on the terminal
.PHONY: session
session: build/host/cds55xx-sim build/arduino-mega/controller.elf
	$(clear)
	@scripts/console.py --session

## feedback: 18 servos' feedback over a 1 Mbps host link: one BULK READ against 18 round trips
.PHONY: feedback
feedback: build/host/cds55xx-sim build/$(BOARD)/controller.elf
	$(clear)
	@test/runs/feedback.py $(BOARD)

SEEDS ?= 1-12

## flood: random bytes from a 1 Mbps host beside a cycle at 250 Hz: the latest goal for each of SEEDS=1-12; fails over its limit
.PHONY: flood
flood: build/host/cds55xx-sim build/$(BOARD)/firmware/flood.elf
	$(clear)
	@test/runs/flood.py $(BOARD) $(SEEDS)
