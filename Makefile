# The whole build, out of tree below build/. `make help` lists the targets; V=1 shows the commands.
#
#   BOARD=name   one of boards/          DEPS=no    install nothing, name what is missing
#   UNITY=dir    your own copy of Unity 2.7 (its src/ and auto/) instead of the fetched one

BOARD ?= atmega128
BOARDS := $(sort $(notdir $(patsubst %/board.mk,%,$(wildcard boards/*/board.mk))))
ifneq ($(words $(filter $(BOARDS),$(BOARD))),1)
$(error there is no board '$(BOARD)'; BOARD= one of: $(BOARDS))
endif

ifneq ($(V),1)
Q := @
endif
say = @printf '  %-8s %s\n' $(1) $(2)

.DELETE_ON_ERROR:
.SECONDEXPANSION:
.SUFFIXES:
.SECONDARY:
.DEFAULT_GOAL := help

WARNINGS := -Wall -Wextra -Wconversion -Werror
DEPFILES := -MMD -MP
INCLUDES := -Iinclude -Isrc/core -Ibuild/texts

# The console's texts, packed.
TEXTS := build/texts/texts.h
$(TEXTS): scripts/texts.py scripts/console.py src/controller/command.h src/controller/commands.h \
		src/controller/sentences.h src/controller/errors.h include/cds55xx/result.h \
		include/cds55xx/diagnose.h | tools
	$(call say,TEXTS,$@)
	@mkdir -p $(@D)
	$(Q)scripts/texts.py > $@

## help: this list
.PHONY: help
help:
	@printf 'cds55xx: a servo controller for CDS55xx servos. BOARD=%s (of: %s)\n\n' '$(BOARD)' '$(BOARDS)'
	@sed -n 's/^## \([a-z-]*\): /\1\t/p' Makefile | awk -F '\t' '{ printf "  make %-10s %s\n", $$1, $$2 }'

# ---- what must be there first ----------------------------------------------------------------------

UNITY ?= build/unity
export UNITY DEPS

## deps: install what is missing (Debian packages; Unity out of its authors' gem)
.PHONY: deps
deps: tools
	@scripts/deps.sh unity

# What all but the tests need.
.PHONY: tools
tools:
	@scripts/deps.sh packages

# Rewritten only when what it holds changes, so that other flags mean other objects.
define stamp
	@mkdir -p $(@D)
	@printf '%s\n' '$(1)' | cmp -s - $@ || printf '%s\n' '$(1)' > $@
endef
.PHONY: force
force:

# ---- AVR: build/<board>/ ---------------------------------------------------------------------------

AVR_CC := avr-gcc
AVR_AR := avr-gcc-ar
AVR_SIZE := avr-size
# Without -mstrict-X gcc 5 reaches fields behind X by adding to it and taking that back.
AVR_COMMON := -std=gnu99 -Os -gdwarf-2 -flto -ffat-lto-objects -ffunction-sections -fdata-sections \
	-fno-common -mstrict-X $(WARNINGS)
# In one partition: then a debugger finds static variables and lines after link-time optimisation.
AVR_LINK := -flto-partition=none -Wl,--gc-sections -Wl,--relax

# The controller's functions share the code that saves registers: 3 KB less flash. Its small functions
# are not copied into their callers, and loops keep what does not change in them: 0.3 KB less.
CONTROLLER_LINK := -mcall-prologues
CONTROLLER_CC := -fno-inline-small-functions -fno-move-loop-invariants

CORE_SRC := $(wildcard src/core/*/*.c)
AVR_SRC := $(wildcard src/avr/*.c)
CONTROLLER_SRC := $(wildcard src/controller/*.c)
EXAMPLE_SRC := $(wildcard examples/*.c)
EXAMPLES := $(foreach b,$(BOARDS),$(EXAMPLE_SRC:examples/%.c=build/$(b)/examples/%.elf))

# The controller's own serial port to the PC, its EEPROM, watchdog and RAM are not the library's
# business.
OWN_SRC := $(addprefix src/avr/,serial.c eeprom.c watchdog.c memory.c)
LIBRARY_SRC := $(CORE_SRC) $(filter-out $(OWN_SRC),$(AVR_SRC))
FIRMWARE_SRC := $(CONTROLLER_SRC) $(OWN_SRC)

# $(1): board, $(2): its folder. Its board.mk has just been included.
define board_rules
$(1)_MCU := $(MCU)
$(1)_FLAGS := -mmcu=$(MCU) -DBOARD_NAME=\"$(1)\" -DF_CPU=$(F_CPU)UL -I$(2) $(OMIT:%=-DOMIT_%) $(INCLUDES) -Isrc/avr $(AVR_COMMON)
$(1)_LIMITS := $(FLASH_MAX) $(RAM_MAX)

build/$(1)/flags: force
	$$(call stamp,$$($(1)_FLAGS) $$(AVR_LINK) $$(CONTROLLER_CC) $$(CONTROLLER_LINK))

build/$(1)/obj/%.o: %.c build/$(1)/flags | tools $(TEXTS)
	$$(call say,CC,$$@)
	@mkdir -p $$(@D)
	$$(Q)$$(AVR_CC) $$($(1)_FLAGS) $$(if $$(filter src/controller/%,$$<),$$(CONTROLLER_CC)) $$(DEPFILES) -c $$< -o $$@

build/$(1)/libcds55xx.a: $(LIBRARY_SRC:%.c=build/$(1)/obj/%.o)
	$$(call say,AR,$$@)
	$$(Q)rm -f $$@ && $$(AVR_AR) rcs $$@ $$^

build/$(1)/controller.elf: $(patsubst %.c,build/$(1)/obj/%.o,$(or $(FIRMWARE),$(FIRMWARE_SRC))) \
		build/$(1)/libcds55xx.a
	$$(call say,LD,$$@)
	$$(Q)$$(AVR_CC) $$($(1)_FLAGS) $$(AVR_LINK) $$(CONTROLLER_LINK) $$^ -o $$@

build/$(1)/examples/%.elf: build/$(1)/obj/examples/%.o build/$(1)/libcds55xx.a
	$$(call say,LD,$$@)
	@mkdir -p $$(@D)
	$$(Q)$$(AVR_CC) $$($(1)_FLAGS) $$(AVR_LINK) $$^ -o $$@

# Programs of the tests that link the library as a robot's firmware does.
build/$(1)/program/%.elf: build/$(1)/obj/test/program/%.o build/$(1)/libcds55xx.a
	$$(call say,LD,$$@)
	@mkdir -p $$(@D)
	$$(Q)$$(AVR_CC) $$($(1)_FLAGS) $$(AVR_LINK) $$^ -o $$@

# Those of the bench likewise.
build/$(1)/bench/%.elf: build/$(1)/obj/test/bench/%.o build/$(1)/libcds55xx.a
	$$(call say,LD,$$@)
	@mkdir -p $$(@D)
	$$(Q)$$(AVR_CC) $$($(1)_FLAGS) $$(AVR_LINK) $$^ -o $$@

# The firmware with something beside it: it includes main.c.
build/$(1)/program/flood.elf: build/$(1)/obj/test/program/flood.o \
		$(patsubst %.c,build/$(1)/obj/%.o,$(filter-out %/main.c,$(FIRMWARE_SRC))) build/$(1)/libcds55xx.a
	$$(call say,LD,$$@)
	@mkdir -p $$(@D)
	$$(Q)$$(AVR_CC) $$($(1)_FLAGS) $$(AVR_LINK) $$(CONTROLLER_LINK) $$^ -o $$@

build/$(1)/%.hex: build/$(1)/%.elf
	$$(call say,HEX,$$@)
	$$(Q)avr-objcopy -O ihex -R .eeprom $$< $$@
endef
# What a board.mk says; each begins empty, or a board that forgets one had that of the board before.
# FUSES: what avrdude writes (-U lfuse:w:...); as-shipped: the fuses are right as shipped; empty: not known.
BOARD_FIELDS := MCU F_CPU FLASH_MAX RAM_MAX PROGRAMMER PORT FLASH_FLAGS FLASH_NOTE FUSES FIRMWARE SIM_MCU OMIT
# $(1): its folder, $(2): those that must be there
read_board = $(foreach f,$(BOARD_FIELDS),$(eval $(f) :=))$(eval include $(1)/board.mk)$(foreach \
	f,$(2),$(if $(strip $($(f))),,$(error $(1)/board.mk: $(f) is missing)))
BOARD_WANTED := MCU F_CPU FLASH_MAX RAM_MAX PROGRAMMER PORT

# A board without a host link names the program that is its FIRMWARE.
$(foreach b,$(BOARDS),$(call read_board,boards/$(b),$(BOARD_WANTED))$(eval $(call board_rules,$(b),boards/$(b))))

# Wirings that none of those has.
TEST_BOARDS := adapter adapter-echo
# A chip to compare with others on.
BENCH_BOARDS := atmega644p
$(foreach b,$(TEST_BOARDS) $(BENCH_BOARDS),$(call read_board,test/boards/$(b),MCU F_CPU)$(eval $(call board_rules,$(b),test/boards/$(b))))

# The variables of the board asked for.
$(call read_board,boards/$(BOARD),$(BOARD_WANTED))

## lib: build/BOARD/libcds55xx.a
.PHONY: lib
lib: build/$(BOARD)/libcds55xx.a

## firmware: build/BOARD/controller.elf and .hex
.PHONY: firmware
firmware: build/$(BOARD)/controller.elf build/$(BOARD)/controller.hex

## examples: the programs of examples/, for BOARD
.PHONY: examples
examples: $(EXAMPLE_SRC:examples/%.c=build/$(BOARD)/examples/%.elf)

## size: flash and RAM of every board's firmware beside its budget
.PHONY: size
size: $(BOARDS:%=build/%/controller.elf) $(EXAMPLES)
	@scripts/size.py $(foreach b,$(BOARDS),build/$(b)/controller.elf $($(b)_LIMITS)) \
	  --note $(EXAMPLES)

## size-map: what the flash of BOARD's firmware is made of, by folder and file
.PHONY: size-map
size-map: build/$(BOARD)/controller.elf
	@scripts/size-map.py $<

## flash: write the firmware with avrdude (PROGRAMMER=, PORT=)
.PHONY: flash
flash: port build/$(BOARD)/controller.hex
	$(if $(FLASH_NOTE),@echo 'note: $(FLASH_NOTE)')
	@scripts/avrdude.sh '$(PORT)' -p $(MCU) -c $(PROGRAMMER) $(FLASH_FLAGS) -U flash:w:build/$(BOARD)/controller.hex:i

# Before the build, which takes longer.
.PHONY: port
port:
	@scripts/avrdude.sh '$(PORT)'

## fuses: write the fuses of BOARD with avrdude: needed once on a new ATmega128
.PHONY: fuses
fuses: tools
ifneq ($(filter as-shipped,$(FUSES)),)
	@echo 'the fuses of $(BOARD) are right as shipped: nothing to write'
else
	$(if $(filter -U,$(FUSES)),,@echo 'the right fuses of $(BOARD) are not known: nothing is written; look them up in the' \
	  'documents of the board, then set FUSES in boards/$(BOARD)/board.mk'; false)
	@scripts/avrdude.sh '$(PORT)' -p $(MCU) -c $(PROGRAMMER) $(FUSES)
endif

# ---- host: the simulator, build/host/cds55xx-sim ---------------------------------------------------

CC := gcc
HOST_COMMON := -std=gnu99 -g -D_GNU_SOURCE $(WARNINGS)
SANITIZE := -O1 -fsanitize=address,undefined -fno-sanitize-recover=all -fno-omit-frame-pointer
SIM_FLAGS := $(HOST_COMMON) -Isim -DSIM_BOARDS_DIR='"$(CURDIR)/boards"'
SIM_FLAGS += -DSIM_SCRIPTS_DIR='"$(CURDIR)/scripts"'
SIM_LIBS := -lsimavr -lm
SIM_SRC := $(wildcard sim/*.c)

build/host/flags: force
	$(call stamp,$(CC) $(SIM_FLAGS) $(SANITIZE))

# $(1): variant, $(2): its flags
define sim_rules
build/host/$(1)/%.o: sim/%.c build/host/flags | tools
	$$(call say,CC,$$@)
	@mkdir -p $$(@D)
	$$(Q)$$(CC) $$(SIM_FLAGS) $(2) $$(DEPFILES) -c $$< -o $$@
endef
$(eval $(call sim_rules,sim,-O2))
$(eval $(call sim_rules,sim-checked,$(SANITIZE)))

build/host/cds55xx-sim: $(SIM_SRC:sim/%.c=build/host/sim/%.o)
	$(call say,LD,$@)
	$(Q)$(CC) $^ $(SIM_LIBS) -o $@

## sim: build/host/cds55xx-sim, the simulated controller, wire and servos
.PHONY: sim
sim: build/host/cds55xx-sim

# ---- the main job ----------------------------------------------------------------------------------

## demo: the manual's examples and a wave of 18 servos, in the simulator; see build/demo/
.PHONY: demo
demo: build/atmega128/controller.elf build/host/cds55xx-sim
	@scripts/demo.sh

SERVOS ?= 1-18
HOST_BAUD ?= board

## run: BOARD's firmware and servos (SERVOS=1-18) in real time, its console a pty (HOST_BAUD=client: the client's rate)
.PHONY: run
run: build/$(BOARD)/controller.elf build/host/cds55xx-sim
	@build/host/cds55xx-sim firmware $< --board $(BOARD) --servos $(SERVOS) --host pty \
	  --host-baud $(HOST_BAUD)

## sim-speed: how many times real time the simulator runs at on this machine
.PHONY: sim-speed
sim-speed: build/host/cds55xx-sim build/atmega128/program/busy.elf
	@scripts/sim-speed.py $^

# ---- the bench -------------------------------------------------------------------------------------

BENCH_NEEDS := build/host/cds55xx-sim $(BOARDS:%=build/%/controller.elf) $(EXAMPLES) build/atmega644p/bench/min.elf \
	$(patsubst %,build/atmega128/bench/%.elf,read prepared noisy sync group absent handlers polls two_mbps cycle8 \
	safe_read safe_calls safe_torque_off turnaround) \
	$(patsubst %,build/%/bench/handlers.elf,arduino-mega arbotix) \
	$(patsubst %,build/atmega128/program/%.elf,cycle50 cycle50_safe flood) build/arduino-mega/program/three_buses.elf

## bench: what the hot path costs, in cycles, beside limits and goals; build/bench.tsv
.PHONY: bench
bench: $(BENCH_NEEDS)
	@scripts/bench.py

## bench-scaling: how the cost grows from 1 to 50 servos; build/bench-scaling.tsv and .svg
.PHONY: bench-scaling
bench-scaling: $(BENCH_NEEDS)
	@scripts/bench.py --scaling

## bench-account: where the cycles of its figures go, function by function
.PHONY: bench-account
bench-account: $(BENCH_NEEDS)
	@scripts/account.py

## bench-docs: make bench, and its tables in README.md and docs/performance.md anew
.PHONY: bench-docs
bench-docs: $(BENCH_NEEDS)
	@scripts/bench.py; scripts/bench.py --docs; scripts/account.py --docs

## bench-ci: make bench twice, the same to the digit, its tables up to date
.PHONY: bench-ci
bench-ci: $(BENCH_NEEDS)
	@scripts/bench.py
	@scripts/bench.py --out build/bench-again.tsv > build/bench-again.log || \
	  { cat build/bench-again.log; exit 1; }
	@cmp build/bench.tsv build/bench-again.tsv
	@scripts/bench.py --docs --check

# ---- faults ----------------------------------------------------------------------------------------

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

build/host/test/obj/%.o: %.c build/host/test/flags | deps $(TEXTS)
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

$(AVR_TEST)/obj/%.o: %.c $(AVR_TEST)/flags | deps $(TEXTS)
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

# ---- checks ----------------------------------------------------------------------------------------

FORMATTED := $(wildcard include/cds55xx/*.h src/*/*.[ch] src/*/*/*.[ch] sim/*.[ch] boards/*/*.h examples/*.c \
	test/*.[ch] test/*/*.[ch])

GENERATED_DOCS := errors registers settings console device

## check: format, layering, docs, headers, machine code; every board built, warnings as errors
.PHONY: check
check: $(BOARDS:%=build/%/controller.elf) $(EXAMPLES) build/host/cds55xx-sim
	@echo '  CHECK    format'; clang-format --dry-run --Werror $(FORMATTED)
	@echo '  CHECK    layering'; scripts/layering.py
	@echo '  CHECK    docs'; for d in $(GENERATED_DOCS); do scripts/$$d.py | diff -u docs/$$d.md - || \
	  { echo "docs/$$d.md is out of date: run make docs"; exit 1; }; done
	@scripts/readme.py --check
	@echo '  CHECK    docs/conformance.md'; scripts/conformance.py
	@echo '  CHECK    machine code'; scripts/elf.py $(BOARDS:%=build/%/libcds55xx.a) \
	  $(BOARDS:%=build/%/controller.elf) $(EXAMPLES)
	@echo '  CHECK    headers'; scripts/headers.py
	@$(MAKE) --no-print-directory size

## eva: Frama-C Eva looks for run-time errors in ring, parser, packet, link and bus (2 min)
.PHONY: eva
eva:
	@scripts/deps.sh eva
	@scripts/eva.py

## docs: write anew what docs and README quote from tables and commands
.PHONY: docs
docs: tools build/atmega128/controller.elf build/host/cds55xx-sim
	@for d in $(GENERATED_DOCS); do scripts/$$d.py > docs/$$d.md; done
	@scripts/readme.py

## format: put all C into the project's format
.PHONY: format
format: tools
	clang-format -i $(FORMATTED)

## clean: remove build/ (but for the fetched Unity)
.PHONY: clean
clean:
	$(Q)find build -mindepth 1 -maxdepth 1 ! -name unity -exec rm -rf {} + 2>/dev/null || true

-include $(shell find build -name '*.d' 2>/dev/null)
