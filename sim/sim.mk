# SPDX-License-Identifier: MIT
# The simulator, build/host/cds55xx-sim, and what runs in it for people.

CC := gcc
HOST_COMMON := -std=gnu99 -g -D_GNU_SOURCE $(WARNINGS)
SANITIZE := -O1 -fsanitize=address,undefined -fno-sanitize-recover=all -fno-omit-frame-pointer
SIM_FLAGS := $(HOST_COMMON) -Isim -DSIM_VERSION=$(VERSION)
# simavr linked statically: the simulator takes 12 to 18 % less CPU time than with calls through the PLT.
SIM_LIBS := -l:libsimavr.a -lelf -lm
# -flto: the simulator takes 4 to 7 % less CPU time.
SIM_FAST := -O2 -flto=auto
SIM_SRC := $(wildcard sim/*.c sim/*/*.c)

build/host/flags: force
	$(call stamp,$(CC) $(SIM_FLAGS) $(SIM_FAST) $(SANITIZE))

# $(1): variant, $(2): its flags
define sim_rules
build/host/$(1)/%.o: sim/%.c build/host/flags | tools
	$$(call say,CC,$$@)
	$$(call folder,$$(@D))
	$$(Q)$$(CC) $$(SIM_FLAGS) $(2) $$(DEPFILES) -c $$< -o $$@
endef
$(eval $(call sim_rules,sim,$(SIM_FAST)))
$(eval $(call sim_rules,sim-checked,$(SANITIZE)))

build/host/cds55xx-sim: $(SIM_SRC:sim/%.c=build/host/sim/%.o)
	$(call say,LD,$@)
	$(Q)$(CC) $(SIM_FAST) $^ $(SIM_LIBS) -o $@

## sim: build/host/cds55xx-sim, the simulated controller, wire and servos
.PHONY: sim
sim: build/host/cds55xx-sim
	$(call built,$^)

# ---- the main job ----------------------------------------------------------------------------------

## demo: the manual's examples, a wave of 18 servos, taught poses, a hexapod that walks; see build/demo/
.PHONY: demo
# It builds firmware and simulator, mostly for those who have just cloned: two jobs.
ifneq ($(filter demo,$(MAKECMDGOALS)),)
MAKEFLAGS += -j2
endif
demo: $(addprefix build/,arduino-mega/controller.elf arduino-mega/examples/hexapod.elf host/cds55xx-sim)
	$(clear)
	@scripts/demo.sh

SERVOS ?= 1-18
ifeq ($(origin SERVO),command line)
$(error SERVO= is not known; did you mean SERVOS=$(SERVO)?)
endif
ifeq ($(strip $(SERVOS)),)
$(error SERVOS= names no servo: give IDs, as in SERVOS=1-6)
endif
SECONDS ?= 5

## run-example: EXAMPLE=two_joints of examples/, or a C file of yours, on BOARD, simulated for SECONDS=5; draws the servos
.PHONY: run-example
EXAMPLE ?= two_joints
OWN_PROGRAM := $(filter %.c,$(EXAMPLE))
ifneq ($(filter run-example,$(MAKECMDGOALS)),)
ifneq ($(OWN_PROGRAM),)
ifeq ($(wildcard $(OWN_PROGRAM)),)
$(error EXAMPLE=$(EXAMPLE) does not exist: name a C file of yours, or an example without .c)
endif
else ifeq ($(call example_source,$(EXAMPLE)),)
$(error there is no example '$(EXAMPLE)'; EXAMPLE= a C file of yours, or one of: $(sort $(basename $(notdir $(wildcard examples/*.c examples/*/*.c)))))
endif
endif
EXAMPLE_NAME := $(basename $(notdir $(EXAMPLE)))
# Compiled each time: two files of the user may have one name. Warnings do not fail it.
build/$(BOARD)/own/%.elf: $(OWN_PROGRAM) build/$(BOARD)/flags build/$(BOARD)/board-checked $(call library_of,$(MCU)) force | tools
	$(call say,LD,$@)
	$(call folder,$(@D))
	$(Q)$(AVR_CC) $(filter-out -Wconversion -Wvla -Werror,$($(BOARD)_FLAGS)) -iquote examples $(AVR_LINK) $(filter %.c %.a,$^) -o $@

run-example: build/$(BOARD)/$(if $(OWN_PROGRAM),own,examples)/$(EXAMPLE_NAME).elf build/host/cds55xx-sim
	$(clear)
	@build/host/cds55xx-sim firmware $< --board $(or $(BOARD_DIR),$(BOARD)) --servos '$(SERVOS)' --seconds $(SECONDS) $(if $(shell grep -l BOARD_HOST_USART $(BOARD_FOLDER)/board.h),--host stdout) --follow --plot build/$(EXAMPLE_NAME).svg
	@echo "picture: build/$(EXAMPLE_NAME).svg"

HOST_BAUD ?= board
ifneq ($(filter-out board client,$(HOST_BAUD)),)
$(error HOST_BAUD=$(HOST_BAUD) is not known: give board, its own rate, or client, the rate of the terminal)
endif

ifneq ($(filter-out 0 1,$(FOLLOW)),)
$(error FOLLOW=$(FOLLOW) is not known: FOLLOW=1 shows the live table)
endif

# The command of make poke for a simulator that make run has started.
POKE = make poke$(if $(BOARD_DIR), BOARD_DIR=$(BOARD_DIR),$(if $(filter-out arduino-mega,$(BOARD)), BOARD=$(BOARD)))

## run: BOARD's firmware and servos (SERVOS=1-18) in real time, its console a pty (HOST_BAUD=client: its rate; FOLLOW=1: live table)
# Its EEPROM keeps what `save` saves from run to run. A person works with it: a breach of the rules of the wire, as by `diagnose` of
# two servos of one ID, is printed, and is no failure of make.
.PHONY: run
run: build/$(BOARD)/controller.elf build/host/cds55xx-sim
	$(clear)
	@build/host/cds55xx-sim firmware $< --board $(or $(BOARD_DIR),$(BOARD)) --servos '$(SERVOS)' --allow-duplicates --host pty \
	  --rules warn --host-baud $(HOST_BAUD) --eeprom build/$(BOARD)/run.eeprom --poke build/$(BOARD)/poke \
	  --poke-hint '$(POKE) DO="load 1 300"' $(if $(filter 1,$(FOLLOW)),--follow)

## poke: acts on the servos of a running make run: DO="load 1 300" turns an output, DO="power 2 off" unplugs
.PHONY: poke
# The shell takes the order from the environment, and so does not change it. The simulator runs, so nothing is built.
poke:
	@[ -n "$$DO" ] || { echo 'say what to do, as in: $(POKE) DO="load 1 300" (docs/simulator.md)'; exit 1; }
	@[ -S build/$(BOARD)/poke$(POKE_OF_PORT) ] || \
	  { echo 'no simulator of $(BOARD) runs: start one with $(subst make poke,make run,$(POKE)), or name its board with BOARD='; exit 1; }
	@build/host/cds55xx-sim poke build/$(BOARD)/poke$(POKE_OF_PORT) "$$DO"

## sim-speed: how many times real time the simulator runs at on this machine
.PHONY: sim-speed
sim-speed: build/host/cds55xx-sim build/atmega128/firmware/busy.elf
	$(clear)
	@scripts/sim-speed.py $^

