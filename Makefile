# SPDX-License-Identifier: MIT
# The whole build, out of tree below build/. `make help` lists the targets; V=1 shows the commands.
#
#   BOARD=name   one of boards/          DEPS=no    install nothing, name what is missing
#   BOARD_DIR=   or the folder of a board of yours
#   PROFILE=name bridge, console, full   UNITY=dir  your own copy of Unity 2.7 (its src/ and auto/)

# Paths of the user. Recipes put PREFIX, DESTDIR and PORT between quotes; the others are names of files in rules, too.
QUOTED_BAD := ' " $$
NAME_BAD := $(QUOTED_BAD) \# : ; % & ( ) * ? [ ] { } | < > = \ `
# $(1): a variable, $(2): characters. Returns the first of them in its value, which is not expanded: it may have a $.
bad_in = $(firstword $(foreach c,$(2),$(findstring $(c),$(value $(1)))) $(if $(word 2,$(3)),blank))
refuse_path = $(if $(2),$(error $(1)=$(value $(1)) has a $(2), which has a meaning in make or the shell; \
  rename the file or folder, or name another one))
$(foreach v,PREFIX DESTDIR PORT,$(call refuse_path,$(v),$(call bad_in,$(v),$(QUOTED_BAD))))
# Values for the command line of the simulator.
refuse_value = $(if $(2),$(error $(1)=$(value $(1)) has a $(2), which has a meaning in make or the shell; leave it out))
$(foreach v,SERVOS SECONDS HOST_BAUD PANEL_PORT SEEDS,$(call refuse_value,$(v),$(call bad_in,$(v),$(NAME_BAD),$(value $(v)))))
$(foreach v,BOARD_DIR ELF EXAMPLE UNITY,$(call refuse_path,$(v),$(call bad_in,$(v),$(NAME_BAD),$(value $(v)))))

ifneq ($(BOARD_DIR),)
ifneq ($(filter command%,$(origin BOARD)),)
$(error BOARD names a board of boards/, BOARD_DIR the folder of another one: leave one of them out)
endif
override BOARD_DIR := $(abspath $(BOARD_DIR))
# The last part of the path. Many robots have a folder `board`: .../robot/board gives robot-board, /board gives board.
override BOARD := $(patsubst %/board,$(notdir $(BOARD_DIR:/board=))-board,$(BOARD_DIR))
override BOARD := $(patsubst -%,%,$(notdir $(BOARD)))
ifeq ($(BOARD),)
$(error BOARD_DIR=$(BOARD_DIR) is no folder of a board; name the folder that has board.mk and board.h)
endif
endif
BOARD_IS_ASKED_FOR := $(BOARD)
BOARD ?= arduino-mega
BOARDS := $(sort $(notdir $(patsubst %/board.mk,%,$(wildcard boards/*/board.mk))))
# The folders of build/ that other targets use: a board of BOARD_DIR may not have such a name.
OTHER_FOLDERS := adapter adapter-echo arduino atmega644p avr-test coverage demo eva firmware host lib mutation panel \
	panel-pictures release runner site unity
# $(1) if it is one word of the list $(2), else nothing.
one_of = $(if $(filter 1,$(words $(1))),$(filter $(2),$(1)))
ifeq ($(BOARD_DIR),)
ifneq ($(or $(call one_of,$(BOARD),$(BOARDS)),no board),$(BOARD))
$(error there is no board '$(BOARD)'; BOARD= one of: $(BOARDS))
endif
else ifneq ($(filter $(BOARD),$(BOARDS)),)
$(error boards/ has a board '$(BOARD)', too: give the folder $(BOARD_DIR) another name)
else ifneq ($(filter $(BOARD),$(OTHER_FOLDERS)),)
$(error build/$(BOARD) has other files than those of a board: give the folder $(BOARD_DIR) another name)
endif
BOARD_FOLDER := $(or $(BOARD_DIR),boards/$(BOARD))
ifneq ($(BOARD_IS_ASKED_FOR),)
LACKS := $(shell scripts/board.py '$(BOARD_FOLDER)' $(patsubst %,'%',$(filter %.c,$(EXAMPLE))))
ifneq ($(LACKS),)
$(error $(LACKS))
endif
endif

# $(call say,WHAT,FILE) in a recipe: the step that begins. On a terminal it is one line, which the next step
# overwrites (\033[?7l: a long line does not wrap); elsewhere each tenth step is printed.
# $(clear): before other output, so that nothing of this line remains.
STEPS :=
step = printf '$(3)%5d  %-8s %s$(4)' $(words $(STEPS)) $(1) $(2)
ifeq ($(V),1)
say = @printf '  %-8s %s\n' $(1) $(2)
else
Q := @
say = $(eval STEPS += x)$(if $(MAKE_TERMOUT),@$(call step,$(1),$(2),\033[K\033[?7l,\033[?7h\r),$(if \
	$(filter %0,$(words $(STEPS))),$(info $(shell $(call step,$(1),$(2))))))
endif
# $(call folder,NAME) in a recipe: makes the folder, once, also under `make -n`. A recipe that removes a folder must make
# it itself. Without a process for each object `time make build/cm510/full.elf` shows 8 % less CPU time.
folder = $(if $(MADE_$(1)),,$(shell mkdir -p $(1))$(eval MADE_$(1) := yes))
clear = @[ ! -t 1 ] || printf '\033[K'
# $(call built,FILES): the end of a target that builds files for the user.
built = @[ ! -t 1 ] || printf '\033[K'; printf '%s\n' $(1)
# make -s
ifneq ($(findstring s,$(firstword -$(MAKEFLAGS))),)
say =
built = @:
endif

.DELETE_ON_ERROR:
.SECONDEXPANSION:
.SUFFIXES:
.SECONDARY:
.DEFAULT_GOAL := help

PARTS := mk/library.mk mk/avr.mk sim/sim.mk mk/install.mk mk/arduino.mk mk/benchmark.mk mk/panel.mk test/test.mk mk/check.mk mk/site.mk mk/release.mk

VERSION := $(shell sed -n 's/.*CDS_VERSION "\(.*\)"/\1/p' include/cds55xx/version.h 2> /dev/null)
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
	$(call folder,$(@D))
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

# What no rule makes: a target that does not exist, or a file that another rule needs. Not with make
# -B, which would ask for each source file, too.
ifeq ($(findstring B,$(firstword -$(MAKEFLAGS))),)
.DEFAULT:
	@echo "there is no $(if $(filter $@,$(MAKECMDGOALS)),target '$@'; 'make help' lists the targets,file '$@', and no rule makes it)" >&2; exit 1
endif

-include $(shell find build -name '*.d' 2>/dev/null)
