# SPDX-License-Identifier: MIT
# The AVR side, for each board, in build/<board>/ (mk/library.mk has the library that they link):
#
#   bridge.elf, console.elf, full.elf   the controller's firmware, one for each profile
#   firmware.elf        the board's own program, where board.mk names a FIRMWARE: such a board has no profile
#   controller.elf      a copy of one of these: what `make flash` writes to the board
#   examples/*.elf      programs of examples/
#   firmware/*.elf      small programs of the tests; benchmark/*.elf: those of make bench

# -flto-partition=none: a debugger finds static variables and lines after link-time optimisation.
# mk/constants.ld is a linker script: it fails if constants do not end within 64 KB.
AVR_LINK := -flto-partition=none -Wl,--gc-sections -Wl,--relax mk/constants.ld

# -mcall-prologues: functions share the code that saves registers, 3 KB less flash.
# -fipa-pta: the compiler knows what a pointer may point to, 0.2 KB less flash.
CONTROLLER_LDFLAGS := -mcall-prologues -fipa-pta
# Small functions are not inlined, invariants stay in their loops, and registers go first to the values in
# most use: 0.5 KB less flash. Conditions are not followed from block to block, and a pointer to a struct is
# not split into its fields: 0.5 KB less, each of the two about half.
CONTROLLER_CFLAGS := -fno-inline-small-functions -fno-move-loop-invariants -fira-algorithm=priority \
	-fno-tree-dominator-opts -fno-ipa-sra

# The source of the example $(1): a file in examples/, or in a folder of its own.
example_source = $(wildcard examples/$(1).c examples/$(1)/$(1).c)
# The examples that run on any board. The programs of the other folders are for the board that their Makefile names.
EXAMPLE_NAMES := $(sort $(basename $(notdir $(wildcard examples/*.c))) hexapod teach)
# Examples that need more RAM or flash than a board has.
TOO_LARGE_EXAMPLES := $(patsubst %,build/arduino-uno/examples/%.elf,hexapod keyframes teach timed_move)
examples_of = $(filter-out $(TOO_LARGE_EXAMPLES),$(EXAMPLE_NAMES:%=build/$(1)/examples/%.elf))
EXAMPLES := $(foreach b,$(BOARDS),$(call examples_of,$(b)))

# Hardware that only the firmware uses: the serial port to the PC, EEPROM, watchdog, RAM.
CONTROLLER_AVR_SRC := $(wildcard src/controller/avr/*.c)
# Objects of the firmware are only linked with LTO. Without machine code of their own they compile in a third
# of the time.
CONTROLLER_CFLAGS += -fno-fat-lto-objects
COMMANDS_SRC := $(wildcard src/controller/console/commands/*.c)
# Sources of all profiles; each profile adds its own (src/controller/profiles). The linker drops unused functions.
COMMON_SRC := $(wildcard src/controller/*.c src/controller/host/*.c src/controller/console/*.c src/controller/robot/*.c)
ALL_PROFILES := bridge console full
ifneq ($(call one_of,$(PROFILE),$(ALL_PROFILES)),$(PROFILE))
$(error there is no profile '$(PROFILE)'; PROFILE= one of: $(ALL_PROFILES))
endif
# The profile of the command line or the environment. read_board empties PROFILE.
ASKED_PROFILE := $(PROFILE)
bridge_SRC := $(filter-out %/console.c %/parse.c %/reply.c %_editor.c,$(COMMON_SRC)) src/controller/profiles/bridge.c
# Each profile with a console has its own editor.
console_SRC := $(filter-out %/line_editor.c %/history.c %/names.c %/typing.c,$(COMMON_SRC) $(COMMANDS_SRC)) src/controller/profiles/console.c
full_SRC := $(filter-out %/short_editor.c,$(COMMON_SRC)) $(COMMANDS_SRC) src/controller/profiles/full.c
# The profile `console` is compiled without the details of the commands, which docs/console.md has. So its
# objects differ from those of the other profiles, and stand in build/<board>/console/.
console_CFLAGS := -DCOMMANDS_WITHOUT_DETAILS
# Sources of the whole controller, for the tests.
CONTROLLER_SRC := $(full_SRC)

# $(1): board, $(2): profile, $(3): sources. Returns their objects.
profile_objects = $(foreach s,$(3),$(if $(filter console/src/controller/%,$(2)/$(s)),\
	build/$(1)/console/$(s:.c=.o),build/$(1)/obj/$(s:.c=.o)))

# $(1): board, $(2): folder of the programs, $(3): the source of one, without .c. They link the library as a robot's
# firmware does.
define program_rule
build/$(1)/$(2)/%.elf: build/$(1)/obj/$(3).o $(call library_of,$(MCU))
	$$(call say,LD,$$@)
	$$(call folder,$$(@D))
	$$(Q)$$(AVR_CC) $$($(1)_FLAGS) $$(AVR_LINK) $$^ -o $$@
endef

# The rules of board $(1), whose folder is $(2). Call read_board first: the rules use its variables.
define board_rules
$(1)_MCU := $(MCU)
$(1)_FLAGS := -mmcu=$(MCU) -DBOARD_NAME=\"$(1)\" -DF_CPU=$(F_CPU)UL -I$(2) $(INCLUDES) -Isrc/controller $(AVR_COMMON)
$(1)_BUDGETS := $(FLASH_MAX) $(RAM_MAX)
$(1)_PROFILE := $(if $(FIRMWARE),,$(or $(ASKED_PROFILE),$(PROFILE),$(lastword $(PROFILES))))
$(1)_PROFILES := $(if $(FIRMWARE),,$(PROFILES))

build/$(1)/flags: force
	$$(call stamp,$$($(1)_FLAGS) $$(AVR_LINK) $$(CONTROLLER_CFLAGS) $$(CONTROLLER_LDFLAGS))

# The first step for a board: a mistake in its board.h is reported once, before anything else is compiled.
build/$(1)/board-checked: $(2)/board.h $(wildcard include/cds55xx/avr/board_check*.h) include/cds55xx/avr/usart_pins.h build/$(1)/flags | tools
	$$(call folder,$$(@D))
	$$(Q)$$(AVR_CC) $$($(1)_FLAGS) -fsyntax-only -include cds55xx/avr/board_check.h -x c /dev/null
	@touch $$@

build/$(1)/obj/%.o: %.c build/$(1)/flags | tools build/$(1)/board-checked
	$$(call say,CC,$$@)
	$$(call folder,$$(@D))
	$$(Q)$$(AVR_CC) $$($(1)_FLAGS) $$(if $$(filter src/controller/%,$$<),$$(CONTROLLER_CFLAGS))$$(if $$(filter examples/%,$$<), -iquote examples) $$(DEPFILES) -c $$< -o $$@

build/$(1)/console/%.o: %.c build/$(1)/flags | tools build/$(1)/board-checked
	$$(call say,CC,$$@)
	$$(call folder,$$(@D))
	$$(Q)$$(AVR_CC) $$($(1)_FLAGS) $$(CONTROLLER_CFLAGS) $$(console_CFLAGS) $$(DEPFILES) -c $$< -o $$@

$(foreach p,$(ALL_PROFILES),
build/$(1)/$(p).elf: $(call profile_objects,$(1),$(p),$($(p)_SRC) $(CONTROLLER_AVR_SRC)) $(call library_of,$(MCU))
	$$(call say,LD,$$@)
	$$(Q)scripts/link.sh $(1) $(p) $$(AVR_CC) $$($(1)_FLAGS) $$(AVR_LINK) $$(CONTROLLER_LDFLAGS) $$^ -o $$@

# For make size-map: a profile may be larger than the flash.
build/$(1)/map/$(p).elf: $(call profile_objects,$(1),$(p),$($(p)_SRC) $(CONTROLLER_AVR_SRC)) $(call library_of,$(MCU))
	$$(call folder,$$(@D))
	$$(Q)$$(AVR_CC) $$($(1)_FLAGS) $$(AVR_LINK) -Wl,--defsym=__TEXT_REGION_LENGTH__=0x100000 $$(CONTROLLER_LDFLAGS) $$^ -o $$@
)
build/$(1)/firmware.elf: $(FIRMWARE:%.c=build/$(1)/obj/%.o) $(call library_of,$(MCU)) build/$(1)/profile
	$$(call say,LD,$$@)
	$$(Q)$$(AVR_CC) $$($(1)_FLAGS) $$(AVR_LINK) $$(filter %.o %.a,$$^) -o $$@

# Rewritten when PROFILE or FIRMWARE changes, so that firmware.elf is linked and controller.elf copied again.
build/$(1)/profile: force
	$$(call stamp,$$(or $$($(1)_PROFILE),$(FIRMWARE)))

build/$(1)/controller.elf: build/$(1)/$$(or $$($(1)_PROFILE),firmware).elf build/$(1)/profile
	$$(Q)cp $$< $$@

$(call program_rule,$(1),examples,$$$$(basename $$$$(call example_source,$$$$*)))

# Programs of the tests.
$(call program_rule,$(1),firmware,test/firmware/library/%)

# Programs of make bench.
$(call program_rule,$(1),benchmark,test/benchmark/%)

# The firmware with a flood of host bytes; flood.c includes main.c.
build/$(1)/firmware/flood.elf: build/$(1)/console/test/firmware/library/flood.o \
		$(call profile_objects,$(1),console,$(filter-out %/main.c,$(console_SRC)) $(CONTROLLER_AVR_SRC)) $(call library_of,$(MCU))
	$$(call say,LD,$$@)
	$$(call folder,$$(@D))
	$$(Q)$$(AVR_CC) $$($(1)_FLAGS) $$(AVR_LINK) $$(CONTROLLER_LDFLAGS) $$^ -o $$@

build/$(1)/%.hex: build/$(1)/%.elf
	$$(call say,HEX,$$@)
	$$(Q)avr-objcopy -O ihex -R .eeprom $$< $$@
endef

# The variables that a board.mk may set. read_board undefines all of them before it includes the file: else a board
# that leaves one out would take the value of the board before it. Then it strips the values, since a comment behind a
# value leaves blanks, and sets the defaults. Only MCU has no default.
#   FLASH_MAX, RAM_MAX   budgets; -: what the chip has, less 640 bytes of stack
#   PROFILE    the profile of the board's firmware (default: the last of PROFILES); PROFILE= on the command line or
#              in the environment overrides it
#   PROFILES   the profiles that its flash has room for (default: all if it has 128 KB, else without full)
#   FUSES      what avrdude writes (-U lfuse:w:...); as-shipped: the fuses are right as shipped; empty: not known
BOARD_FIELDS := MCU F_CPU FLASH_MAX RAM_MAX PROGRAMMER PORT FLASH_FLAGS FLASH_NOTE FUSES FIRMWARE SIM_MCU PROFILE PROFILES
default_F_CPU := 16000000
default_FLASH_MAX := -
default_RAM_MAX := -
default_PROGRAMMER := usbasp
default_PORT := usb
default_PROFILES = $(if $(filter $(avr5_MCUS),$(MCU)),bridge console,$(ALL_PROFILES))
# $(1): the folder of the board
read_board = $(foreach f,$(BOARD_FIELDS),$(eval undefine $(f)))$(eval include $(1)/board.mk)$(foreach \
	f,$(BOARD_FIELDS),$(eval $(f) := $$(or $$(strip $$($(f))),$$(default_$(f)))))$(if \
	$(call one_of,$(MCU),$(LIBRARY_MCUS)),,$(error $(1)/board.mk: $(if $(MCU),there is no library for MCU \
	'$(MCU)',MCU is missing); MCU := one of: $(LIBRARY_MCUS)))$(if \
	$(FIRMWARE),,$(if $(filter $(SMALL_MCUS),$(MCU)),$(error $(1)/board.mk: the controller does not fit the RAM of \
	$(MCU); name a program of yours in FIRMWARE)))

# The rules of all boards. A board without a host link has a FIRMWARE: the source of its own program.
$(foreach b,$(BOARDS),$(call read_board,boards/$(b))$(eval $(call board_rules,$(b),boards/$(b))))

# Boards of the tests: wirings that no real board has.
TEST_BOARDS := adapter adapter-echo
# Board of make bench: another chip, to compare with.
BENCH_BOARDS := atmega644p
$(foreach b,$(TEST_BOARDS) $(BENCH_BOARDS),$(call read_board,test/boards/$(b))$(eval $(call board_rules,$(b),test/boards/$(b))))

# $(1): board. profile_elfs: the ELF of each profile that fits its flash, or of its own program. too_large: the
# profiles that do not fit.
profile_elfs = $(if $($(1)_PROFILE),$($(1)_PROFILES:%=build/$(1)/%.elf),build/$(1)/firmware.elf)
too_large = $(if $($(1)_PROFILE),$(patsubst %,$(1)/%.elf,$(filter-out $($(1)_PROFILES),$(ALL_PROFILES))))

# The variables of the board asked for. A board of the user's that names no FIRMWARE runs the C file in EXAMPLE.
default_FIRMWARE := $(if $(BOARD_DIR),$(filter %.c,$(EXAMPLE)))
$(call read_board,$(BOARD_FOLDER))
$(if $(BOARD_DIR),$(eval $(call board_rules,$(BOARD),$(BOARD_DIR))))
ifneq ($(F_CPU),16000000)
$(error $(BOARD_FOLDER)/board.mk: F_CPU is $(F_CPU); F_CPU := 16000000, which is the only clock that works)
endif
ifneq ($(filter-out $(ALL_PROFILES),$(PROFILES)),)
$(error $(BOARD_FOLDER)/board.mk: there is no profile '$(filter-out $(ALL_PROFILES),$(PROFILES))'; PROFILES := some of: $(ALL_PROFILES))
endif
ifneq ($(or $(ASKED_PROFILE),$(call one_of,$(PROFILE),$(PROFILES))),$(or $(ASKED_PROFILE),$(PROFILE)))
$(error $(BOARD_FOLDER)/board.mk: PROFILE is '$(PROFILE)'; PROFILE := one of: $(PROFILES))
endif
ifneq ($(FIRMWARE),$(default_FIRMWARE))
ifneq ($(words $(FIRMWARE)) $(wildcard $(filter %.c,$(FIRMWARE))),1 $(FIRMWARE))
$(error $(BOARD_FOLDER)/board.mk: FIRMWARE is '$(FIRMWARE)', which is no C file; FIRMWARE := its absolute path, or its path from $(CURDIR))
endif
endif
# A make that this one starts gets the PROFILE that was asked for, not the one of board.mk.
export PROFILE := $(ASKED_PROFILE)

ifneq ($(ASKED_PROFILE),)
ifneq ($(FIRMWARE),)
$(error $(BOARD) has no profiles, its firmware is $(FIRMWARE); leave PROFILE out)
endif
ifeq ($(filter $(ASKED_PROFILE),$($(BOARD)_PROFILES)),)
$(error profile '$(ASKED_PROFILE)' does not fit the flash of $(BOARD); PROFILE= one of: $($(BOARD)_PROFILES))
endif
endif

## lib: build/lib/libcds55xx-<mcu>.a for the chip of BOARD
.PHONY: lib
lib: $(call library_of,$(MCU))
	$(call built,$^)

## firmware: build/BOARD/controller.elf and .hex (PROFILE=bridge, console or full)
.PHONY: firmware
firmware: build/$(BOARD)/controller.elf build/$(BOARD)/controller.hex
	$(call built,$^)

## examples: the programs of examples/ that run on any board, for BOARD
.PHONY: examples
examples: $(call examples_of,$(BOARD))
	$(call built,$^)

# For scripts/measure.py.
.PHONY: list-examples
list-examples:
	@printf '%s\n' $(EXAMPLES)

## size: flash and RAM of each profile on every board, or of BOARD_DIR, beside its budget
SIZED := $(if $(BOARD_DIR),$(BOARD),$(BOARDS))
NOTED := $(if $(BOARD_DIR),,$(EXAMPLES))
.PHONY: size size-elfs
size-elfs: $(foreach b,$(SIZED),$(call profile_elfs,$(b))) $(NOTED)
	@:
# -k: a program that does not fit takes no other row away.
size:
	@rm -f build/size-failed; $(MAKE) -k --no-print-directory size-elfs || touch build/size-failed
	$(clear)
	@scripts/size.py $(foreach b,$(SIZED),$(foreach f,$(call profile_elfs,$(b)),$(f) $($(b)_BUDGETS))) \
	  --note $(NOTED) --too-large $(foreach b,$(SIZED),$(call too_large,$(b)))
	@[ ! -e build/size-failed ] || { echo 'a build failed: its message is above the table'; false; }

## size-map: what the flash of BOARD's firmware is made of, by folder and file
.PHONY: size-map
size-map: build/$(BOARD)/$(if $($(BOARD)_PROFILE),map/$($(BOARD)_PROFILE),firmware).elf
	$(clear)
	@scripts/size-map.py $<

ifneq ($(ELF),)
ifeq ($(wildcard $(ELF)),)
$(error ELF=$(ELF) does not exist: name the program that make flash shall write)
endif
build/$(BOARD)/flash.hex: $(ELF) force | tools
	$(call folder,$(@D))
	$(Q)avr-objcopy -O ihex -R .eeprom $< $@
endif
FLASH_HEX := build/$(BOARD)/$(if $(ELF),flash,controller).hex

## flash: write the firmware, or another program (ELF=), with avrdude (PROGRAMMER=, PORT=)
.PHONY: flash
flash: port $(FLASH_HEX)
	$(if $(FLASH_NOTE),$(clear); echo 'note: $(FLASH_NOTE)')
	@scripts/avrdude.sh '$(PORT)' -p $(MCU) -c $(PROGRAMMER) $(FLASH_FLAGS) -U flash:w:$(FLASH_HEX):i

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
	  'documents of the board, then set FUSES in $(BOARD_FOLDER)/board.mk'; false)
	@scripts/avrdude.sh '$(PORT)' -p $(MCU) -c $(PROGRAMMER) $(FUSES)
endif

