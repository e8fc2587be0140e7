# SPDX-License-Identifier: MIT
# Checks, and documents that are made from tables.

FORMATTED := $(wildcard include/cds55xx/*.h include/cds55xx/*/*.h src/*/*.[ch] src/*/*/*.[ch] src/*/*/*/*.[ch] sim/*.[ch] sim/*/*.[ch] boards/*/*.h examples/*.[ch] examples/*/*.c \
	test/*/*.[ch] test/*/*/*.[ch] arduino/*.h arduino/*.cpp arduino/examples/*/*.ino test/firmware/arduino/*.ino)

# Each public header compiles alone, as C99 and as C++11.
PUBLIC_HEADERS := $(filter-out %/avr.h,$(wildcard include/cds55xx/*.h))
PORT_HEADERS := include/cds55xx/avr.h $(wildcard include/cds55xx/avr/*.h)
ALONE := -pedantic-errors -Wall -Wextra -Werror -fsyntax-only -Iinclude

GENERATED_DOCS := errors registers settings console device

## check: format, layering, docs, headers, machine code; every board built
.PHONY: check
check: tools
	@echo '  CHECK    format'; clang-format --dry-run --Werror $(FORMATTED)
	@echo '  CHECK    licences'; scripts/spdx.py
	@echo '  CHECK    layering'; scripts/layering.py
	@$(MAKE) --no-print-directory check-docs
	@$(MAKE) --no-print-directory check-builds
	@$(MAKE) --no-print-directory size

# Before the other builds, which take longer.
.PHONY: check-docs
check-docs: build/arduino-mega/controller.elf build/host/cds55xx-sim
	$(clear)
	@scripts/deps.sh docs
	@echo '  CHECK    docs'; for d in $(GENERATED_DOCS); do scripts/$$d.py | diff -u docs/$$d.md - || \
	  { echo "docs/$$d.md is out of date: run make docs"; exit 1; }; done
	@echo '  CHECK    links'; scripts/links.py
	@scripts/readme.py --check
	@echo '  CHECK    docs/internals/conformance.md'; scripts/conformance.py

.PHONY: check-builds
check-builds: $(BOARDS:%=build/%/controller.elf) $(EXAMPLES)
	$(clear)
	@echo '  CHECK    machine code'; scripts/elf.py $(sort $(foreach b,$(BOARDS),$(call library_of,$($(b)_MCU)))) \
	  $(BOARDS:%=build/%/controller.elf) $(EXAMPLES)
	@echo '  CHECK    headers'; for h in $(PUBLIC_HEADERS); do \
	  echo 'extern int not_empty;' | gcc -std=c99 $(ALONE) -include $$h -x c - && \
	  echo 'extern int not_empty;' | avr-g++ -mmcu=atmega128 -std=c++11 $(ALONE) -include $$h -x c++ - || exit 1; done
	@for h in $(PORT_HEADERS); do for l in 'c -std=gnu99' 'c++ -std=gnu++11'; do echo 'extern int not_empty;' | \
	  $(AVR_CC) -mmcu=atmega128 -DF_CPU=16000000UL -Os -Iboards/atmega128 $(ALONE) -include $$h -x $$l - || exit 1; done; done

## eva: Frama-C Eva looks for run-time errors in ring, parser, packet, link and bus (2 min)
.PHONY: eva
eva:
	@scripts/deps.sh eva
	@scripts/eva.py

## docs: renew what documents quote from tables and commands
.PHONY: docs
docs: tools build/arduino-mega/controller.elf build/host/cds55xx-sim
	$(clear)
	@scripts/deps.sh docs
	@for d in $(GENERATED_DOCS); do scripts/$$d.py > build/$$d.md && mv build/$$d.md docs/$$d.md || exit 1; done
	@scripts/readme.py
	@! command -v node > /dev/null || node panel/notices.mjs docs/panel.md

## pictures: draw docs/img/*.svg from runs of the simulator
.PHONY: pictures
pictures: tools build/host/cds55xx-sim $(addprefix build/atmega128/,controller.elf firmware/curves.elf firmware/motion.elf) \
		build/arduino-mega/examples/hexapod.elf
	$(clear)
	@scripts/pictures.py

## format: put all C into the project's format
.PHONY: format
format: tools
	$(call say,FORMAT,'$(words $(FORMATTED)) files')
	$(Q)clang-format -i $(FORMATTED)
