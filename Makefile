# The whole build, out of tree below build/. `make help` lists the targets; V=1 shows the commands.
#
#   BOARD=name   one of boards/          DEPS=no    install nothing, name what is missing
#   PROFILE=name bridge, console, full   UNITY=dir  your own copy of Unity 2.7 (its src/ and auto/)

BOARD ?= atmega128
BOARDS := $(sort $(notdir $(patsubst %/board.mk,%,$(wildcard boards/*/board.mk))))
# $(1) if it is one word of the list $(2), else nothing.
one_of = $(if $(filter 1,$(words $(1))),$(filter $(2),$(1)))
ifneq ($(or $(call one_of,$(BOARD),$(BOARDS)),no board),$(BOARD))
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

PARTS := mk/avr.mk mk/arduino.mk sim/sim.mk mk/benchmark.mk test/test.mk mk/check.mk

WARNINGS := -Wall -Wextra -Wconversion -Wvla -Werror
DEPFILES := -MMD -MP
INCLUDES := -Iinclude -Isrc/core

## help: this list
.PHONY: help
help:
	@printf 'cds55xx: a servo controller for CDS55xx servos. BOARD=%s (of: %s)\n\n' '$(BOARD)' '$(BOARDS)'
	@sed -n 's/^## \([a-z-]*\): /\1\t/p' $(PARTS) Makefile | awk -F '\t' '{ printf "  make %-13s %s\n", $$1, $$2 }'

# ---- what must be there first ----------------------------------------------------------------------

UNITY ?= build/unity
export UNITY DEPS

## deps: install what is missing (Debian packages; Unity out of its authors' gem)
.PHONY: deps
deps: tools
	@scripts/deps.sh unity

# The tools that all targets but the tests need.
.PHONY: tools
tools:
	@scripts/deps.sh packages

# Writes $(1) to the target, but only if the content changes. Objects depend on such a file that holds their
# flags, so they are compiled again when the flags change.
define stamp
	@mkdir -p $(@D)
	@printf '%s\n' '$(1)' | cmp -s - $@ || printf '%s\n' '$(1)' > $@
endef
.PHONY: force
force:

# ---- the parts -------------------------------------------------------------------------------------

include $(PARTS)


## clean: remove build/ (but for the fetched Unity)
.PHONY: clean
clean:
	$(Q)find build -mindepth 1 -maxdepth 1 ! -name unity -exec rm -rf {} + 2>/dev/null || true

-include $(shell find build -name '*.d' 2>/dev/null)
