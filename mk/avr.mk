# The AVR side: the library, the firmware and the examples, for each board, in build/<board>/.

AVR_CC := avr-gcc
AVR_AR := avr-gcc-ar
AVR_SIZE := avr-size
# Without -mstrict-X gcc 5 reaches fields behind X by adding to it and taking that back.
AVR_COMMON := -std=gnu99 -Os -gdwarf-2 -flto -ffat-lto-objects -ffunction-sections -fdata-sections \
	-fno-common -mstrict-X $(WARNINGS)
# In one partition: then a debugger finds static variables and lines after link-time optimisation.
# The last is a script: it fails if constants do not end within 64 KB.
AVR_LINK := -flto-partition=none -Wl,--gc-sections -Wl,--relax mk/constants.ld

# The controller's functions share the code that saves registers: 3 KB less flash. Its small functions
# are not copied into their callers, and loops keep what does not change in them: 0.3 KB less.
CONTROLLER_LINK := -mcall-prologues
CONTROLLER_CC := -fno-inline-small-functions -fno-move-loop-invariants

CORE_SRC := $(wildcard src/core/*/*.c)
AVR_SRC := $(wildcard src/avr/*.c)
EXAMPLE_SRC := $(wildcard examples/*.c)
EXAMPLES := $(foreach b,$(BOARDS),$(EXAMPLE_SRC:examples/%.c=build/$(b)/examples/%.elf))

LIBRARY_SRC := $(CORE_SRC) $(AVR_SRC)

# The hardware that only the firmware uses: the serial port to the PC, EEPROM, watchdog, RAM.
CONTROLLER_AVR_SRC := $(wildcard src/controller/avr/*.c)
COMMANDS_SRC := $(wildcard src/controller/console/commands/*.c)
# What all profiles link, and what each adds (src/controller/profiles). The linker drops what is not used.
COMMON_SRC := $(wildcard src/controller/*.c src/controller/host/*.c src/controller/console/*.c src/controller/robot/*.c)
ALL_PROFILES := bridge console full
ifneq ($(filter-out $(ALL_PROFILES),$(PROFILE)),)
$(error there is no profile '$(PROFILE)'; PROFILE= one of: $(ALL_PROFILES))
endif
bridge_SRC := $(filter-out %/console.c %/parse.c %/reply.c,$(COMMON_SRC)) src/controller/profiles/bridge.c
console_SRC := $(COMMON_SRC) $(COMMANDS_SRC) src/controller/profiles/console.c
full_SRC := $(COMMON_SRC) $(COMMANDS_SRC) src/controller/profiles/full.c
# The commands of the profile `console`, whose objects are its own, leave details to docs/console.md.
console_CC := -DCOMMANDS_WITHOUT_DETAILS
# The whole controller, for the tests.
CONTROLLER_SRC := $(full_SRC)

# $(1): board, $(2): profile, $(3): sources. The objects of them.
profile_objects = $(foreach s,$(3),$(if $(filter console/src/controller/console/commands/%,$(2)/$(s)),\
	build/$(1)/console/$(s:.c=.o),build/$(1)/obj/$(s:.c=.o)))

# $(1): board, $(2): its folder. Its board.mk has just been included.
define board_rules
$(1)_MCU := $(MCU)
$(1)_FLAGS := -mmcu=$(MCU) -DBOARD_NAME=\"$(1)\" -DF_CPU=$(F_CPU)UL -I$(2) $(INCLUDES) -Isrc/avr -Isrc/controller $(AVR_COMMON)
$(1)_LIMITS := $(FLASH_MAX) $(RAM_MAX)
$(1)_PROFILE := $(if $(FIRMWARE),,$(or $(PROFILE),full))
$(1)_PROFILES := $(if $(FIRMWARE),,$(or $(PROFILES),$(ALL_PROFILES)))

build/$(1)/flags: force
	$$(call stamp,$$($(1)_FLAGS) $$(AVR_LINK) $$(CONTROLLER_CC) $$(CONTROLLER_LINK))

build/$(1)/obj/%.o: %.c build/$(1)/flags | tools
	$$(call say,CC,$$@)
	@mkdir -p $$(@D)
	$$(Q)$$(AVR_CC) $$($(1)_FLAGS) $$(if $$(filter src/controller/%,$$<),$$(CONTROLLER_CC)) $$(DEPFILES) -c $$< -o $$@

build/$(1)/console/%.o: %.c build/$(1)/flags | tools
	$$(call say,CC,$$@)
	@mkdir -p $$(@D)
	$$(Q)$$(AVR_CC) $$($(1)_FLAGS) $$(CONTROLLER_CC) $$(console_CC) $$(DEPFILES) -c $$< -o $$@

build/$(1)/libcds55xx.a: $(LIBRARY_SRC:%.c=build/$(1)/obj/%.o)
	$$(call say,AR,$$@)
	$$(Q)rm -f $$@ && $$(AVR_AR) rcs $$@ $$^

$(foreach p,$(ALL_PROFILES),
build/$(1)/$(p).elf: $(call profile_objects,$(1),$(p),$($(p)_SRC) $(CONTROLLER_AVR_SRC)) build/$(1)/libcds55xx.a
	$$(call say,LD,$$@)
	$$(Q)$$(AVR_CC) $$($(1)_FLAGS) $$(AVR_LINK) $$(CONTROLLER_LINK) $$^ -o $$@
)
build/$(1)/firmware.elf: $(FIRMWARE:%.c=build/$(1)/obj/%.o) build/$(1)/libcds55xx.a
	$$(call say,LD,$$@)
	$$(Q)$$(AVR_CC) $$($(1)_FLAGS) $$(AVR_LINK) $$^ -o $$@

# The firmware of the board: that of its profile, or its own program.
build/$(1)/profile: force
	$$(call stamp,$$($(1)_PROFILE))

build/$(1)/controller.elf: build/$(1)/$$(or $$($(1)_PROFILE),firmware).elf build/$(1)/profile
	$$(Q)cp $$< $$@

build/$(1)/examples/%.elf: build/$(1)/obj/examples/%.o build/$(1)/libcds55xx.a
	$$(call say,LD,$$@)
	@mkdir -p $$(@D)
	$$(Q)$$(AVR_CC) $$($(1)_FLAGS) $$(AVR_LINK) $$^ -o $$@

# Programs of the tests that link the library as a robot's firmware does.
build/$(1)/firmware/%.elf: build/$(1)/obj/test/firmware/library/%.o build/$(1)/libcds55xx.a
	$$(call say,LD,$$@)
	@mkdir -p $$(@D)
	$$(Q)$$(AVR_CC) $$($(1)_FLAGS) $$(AVR_LINK) $$^ -o $$@

# Those of the bench likewise.
build/$(1)/benchmark/%.elf: build/$(1)/obj/test/benchmark/%.o build/$(1)/libcds55xx.a
	$$(call say,LD,$$@)
	@mkdir -p $$(@D)
	$$(Q)$$(AVR_CC) $$($(1)_FLAGS) $$(AVR_LINK) $$^ -o $$@

# The firmware with something beside it: it includes main.c.
build/$(1)/firmware/flood.elf: build/$(1)/obj/test/firmware/library/flood.o \
		$(call profile_objects,$(1),console,$(filter-out %/main.c,$(console_SRC)) $(CONTROLLER_AVR_SRC)) build/$(1)/libcds55xx.a
	$$(call say,LD,$$@)
	@mkdir -p $$(@D)
	$$(Q)$$(AVR_CC) $$($(1)_FLAGS) $$(AVR_LINK) $$(CONTROLLER_LINK) $$^ -o $$@

build/$(1)/%.hex: build/$(1)/%.elf
	$$(call say,HEX,$$@)
	$$(Q)avr-objcopy -O ihex -R .eeprom $$< $$@
endef
# What a board.mk says; each begins empty, or a board that forgets one had that of the board before.
# PROFILE: that of its firmware (full), which PROFILE= overrides; PROFILES: those that its flash has room for (all).
# FUSES: what avrdude writes (-U lfuse:w:...); as-shipped: the fuses are right as shipped; empty: not known.
BOARD_FIELDS := MCU F_CPU FLASH_MAX RAM_MAX PROGRAMMER PORT FLASH_FLAGS FLASH_NOTE FUSES FIRMWARE SIM_MCU PROFILE PROFILES
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

# $(1): board. The ELF of each profile that has room, or of its own program; and the profiles that have none.
firmwares = $(if $($(1)_PROFILE),$($(1)_PROFILES:%=build/$(1)/%.elf),build/$(1)/firmware.elf)
too_large = $(if $($(1)_PROFILE),$(patsubst %,$(1)/%.elf,$(filter-out $($(1)_PROFILES),$(ALL_PROFILES))))
FIRMWARES := $(foreach b,$(BOARDS),$(call firmwares,$(b)))

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

## size: flash and RAM of each profile on every board beside its budget
.PHONY: size
size: $(FIRMWARES) $(EXAMPLES)
	@scripts/size.py $(foreach b,$(BOARDS),$(foreach f,$(call firmwares,$(b)),$(f) $($(b)_LIMITS))) \
	  --note $(EXAMPLES) --too-large $(foreach b,$(BOARDS),$(call too_large,$(b)))

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

