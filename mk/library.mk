# SPDX-License-Identifier: MIT
# The library: build/lib/libcds55xx-<mcu>.a, an archive for each chip. It knows no board: a program gets the
# USARTs, timer and pins of its board by CDS_AVR_BUS and CDS_AVR_CLOCK (include/cds55xx/avr.h).

# The same sources make the same bytes, wherever they are. PWD: the name of the folder in the debugging information,
# which a debugger takes for its own. -frandom-seed: names in the objects come from the target, not from a random
# number.
AVR_CC = PWD=/proc/self/cwd avr-gcc -frandom-seed=$@
AVR_AR := avr-gcc-ar
AVR_SIZE := avr-size
# -mstrict-X: without it gcc 5 adds an offset to X and subtracts it again for each field.
AVR_COMMON := -std=gnu99 -Os -gdwarf-2 -flto -ffat-lto-objects -ffunction-sections -fdata-sections \
	-fno-common -mstrict-X $(WARNINGS)

# The chips that the port supports, by architecture: their USARTs have a number, they have a 16-bit timer that
# the port knows, and at least 1 KB of RAM.
avr5_MCUS := at90can64 atmega164p atmega168 atmega168p atmega324p atmega328 atmega328p atmega64 atmega640 atmega644 atmega644p
avr51_MCUS := at90can128 atmega128 atmega1280 atmega1281 atmega1284 atmega1284p
avr6_MCUS := atmega2560 atmega2561
# Of these the ones whose 1 or 2 KB of RAM are too few for the controller's firmware.
SMALL_MCUS := atmega164p atmega168 atmega168p atmega324p atmega328 atmega328p
LIBRARY_ARCHS := avr5 avr51 avr6
LIBRARY_MCUS := $(sort $(foreach a,$(LIBRARY_ARCHS),$($(a)_MCUS)))

CORE_SRC := $(wildcard src/core/*/*.c)
LIBRARY_CFLAGS := $(INCLUDES) $(AVR_COMMON)

# $(1): a chip. Returns its archive.
library_of = build/lib/libcds55xx-$(1).a

build/lib/flags: force
	$(call stamp,$(LIBRARY_CFLAGS))

# Rewritten when a source or chip is added or removed, so that the archives are built again.
build/lib/sources: force
	$(call stamp,$(CORE_SRC) $(LIBRARY_MCUS))

# The core knows no chip, so its objects are the same for all chips of an architecture.
# $(1): an architecture
define core_rules
build/lib/$(1)/%.o: %.c build/lib/flags | tools
	$$(call say,CC,$$@)
	$$(call folder,$$(@D))
	$$(Q)$$(AVR_CC) -mmcu=$(lastword $($(1)_MCUS)) $$(LIBRARY_CFLAGS) $$(DEPFILES) -c $$< -o $$@

$(foreach m,$($(1)_MCUS),$(call library_rules,$(m),$(1),$(filter-out $(m),$(LIBRARY_MCUS))))
endef

# $(1): a chip, $(2): its architecture, $(3): all other chips. For each of them the archive has a member that
# ends the link of a program for that chip with a message: src/avr/library.S.
define library_rules
build/lib/$(1)/library.o: src/avr/library.S build/lib/sources | tools
	$$(call folder,$$(@D))
	$$(Q)$$(AVR_CC) -mmcu=$(1) -c $$< -o $$@
	$$(Q)for m in $(3); do $$(AVR_CC) -mmcu=$(1) -DPROGRAM_MCU=$$$$m -c $$< -o $$(@D)/for_$$$$m.o || exit 1; done

$(call library_of,$(1)): $(CORE_SRC:%.c=build/lib/$(2)/%.o) build/lib/$(1)/library.o build/lib/sources
	$$(call say,AR,$$@)
	$$(Q)rm -f $$@ && $$(AVR_AR) rcsD $$@ $$(filter %.o,$$^) $(3:%=build/lib/$(1)/for_%.o)

endef
$(foreach a,$(LIBRARY_ARCHS),$(eval $(call core_rules,$(a))))

MCUS ?= $(LIBRARY_MCUS)
ifeq ($(strip $(MCUS)),)
$(error MCUS= names no chip; leave it out, or MCUS= some of: $(LIBRARY_MCUS))
endif
ifneq ($(filter-out $(LIBRARY_MCUS),$(MCUS)),)
$(error there is no library for '$(filter-out $(LIBRARY_MCUS),$(MCUS))'; MCUS= some of: $(LIBRARY_MCUS))
endif

## libs: the library for each chip (MCUS=): build/lib/libcds55xx-<mcu>.a
.PHONY: libs
libs: $(foreach m,$(MCUS),$(call library_of,$(m)))
	$(clear)
