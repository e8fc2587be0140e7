# SPDX-License-Identifier: MIT
# The control panel: a web page (panel/), bundled into build/panel.

PANEL_MODULES := panel/node_modules/.package-lock.json
PANEL_SRC := $(wildcard panel/src/*.js panel/src/*/*.js panel/src/*.css panel/src/*/*.css panel/public/* panel/bundle/*) \
	panel/index.html panel/build.mjs
PANEL_TABLES := build/panel-tables.json
PANEL_TABLE_SOURCES := $(wildcard scripts/panel-tables.py scripts/registers.py scripts/device.py scripts/settings.py \
	scripts/errors.py scripts/console.py src/controller/console/commands/*.c src/controller/profiles/*.c) \
	include/cds55xx/control_table.h include/cds55xx/result.h include/cds55xx/diagnose.h include/cds55xx/version.h \
	src/controller/host/device.h src/controller/robot/settings.h src/controller/console/errors.h src/core/wire/units.c

# npm ci installs exactly what panel/package-lock.json names.
$(PANEL_MODULES): panel/package.json panel/package-lock.json
	@scripts/deps.sh panel
	$(call say,NPM,panel/node_modules)
	$(Q)why=$$(npm ci --prefix panel --no-audit --no-fund --no-update-notifier --loglevel=error --fetch-retry-mintimeout=500 \
	  --fetch-retry-maxtimeout=2000 --fetch-timeout=60000 2>&1) || { echo "npm cannot install the packages of the control panel:" \
	  "$$(printf '%s\n' "$$why" | head -1); connect the network, or copy panel/node_modules of another clone and touch $@" >&2; exit 1; }
	$(Q)touch $@

$(PANEL_TABLES): $(PANEL_TABLE_SOURCES) | tools
	$(call say,TABLES,$@)
	$(call folder,$(@D))
	$(Q)scripts/panel-tables.py > $@

build/panel/app.js: $(PANEL_SRC) $(PANEL_TABLES) $(PANEL_MODULES)
	$(call say,BUNDLE,build/panel)
	$(clear)
	$(Q)node panel/build.mjs $(PANEL_TABLES) build/panel

## deps-panel: install what the control panel needs (node and npm if missing, websockify, Chromium, npm packages)
.PHONY: deps-panel
deps-panel:
	@scripts/deps.sh panel
	@scripts/deps.sh panel-test
	$(Q)$(MAKE) --no-print-directory $(PANEL_MODULES)

## panel-build: the control panel as files for a web server, in build/panel
.PHONY: panel-build
panel-build: build/panel/app.js
	$(call built,build/panel)

build/panel.zip: build/panel/app.js
	$(Q)scripts/pack.py $@ $(<D) cds55xx-panel-$(VERSION)

PANEL_BOARD := arduino-mega
PANEL_PORT ?= 8055

# Settings of the simulated controller: 1 Mbps to the page. `make panel` keeps what is saved from run to run: all that it
# needs is order-only, so that no newer file makes it again.
build/panel.eeprom: | sim/panel.script build/$(PANEL_BOARD)/controller.elf build/host/cds55xx-sim
	$(call say,SIM,$@)
	@build/host/cds55xx-sim firmware build/$(PANEL_BOARD)/controller.elf --board $(PANEL_BOARD) --servos 1 \
	  --eeprom $@ --script sim/panel.script >/dev/null

# The suffix of the socket of make poke: each PANEL_PORT has its own.
POKE_OF_PORT = $(addprefix -,$(filter-out 8055,$(PANEL_PORT)))

## panel: the control panel with a simulated robot (SERVOS=1-18), at an address of this machine (PANEL_PORT=8055)
.PHONY: panel
panel: build/panel/app.js build/$(PANEL_BOARD)/controller.elf build/host/cds55xx-sim build/panel.eeprom
	$(clear)
	@scripts/panel.py build/$(PANEL_BOARD)/controller.elf --board $(PANEL_BOARD) --servos '$(SERVOS)' \
	  --eeprom build/panel.eeprom --port '$(PANEL_PORT)' -- --allow-duplicates --poke build/$(PANEL_BOARD)/poke$(POKE_OF_PORT) --poke-hint \
	  'make poke $(if $(POKE_OF_PORT),PANEL_PORT=$(PANEL_PORT) )DO="load 1 300"'

# Suites: `unit` has no simulator.
# `session` has the firmware in the simulator, and no browser.
# `browser` has the firmware in the simulator and the page in Chromium.
PANEL_SUITES := $(sort $(wildcard panel/test/unit/*.test.js panel/test/session/*.test.js panel/test/browser/*.test.js))
PANEL_NEEDS := $(PANEL_MODULES) build/panel/app.js build/panel.eeprom build/host/cds55xx-sim \
	$(foreach b,atmega128 arduino-mega arbotix,build/$(b)/controller.elf) build/atmega128/bridge.elf

## test-panel: the tests of the control panel, in Chromium with the firmware in the simulator (T=word)
.PHONY: test-panel
test-panel: $(PANEL_NEEDS)
	@scripts/deps.sh panel-test
	$(clear)
	@scripts/run-tests.py --times build/test-panel-times.tsv \
	  $(if $(T),$(foreach f,$(PANEL_SUITES),$(if $(strip $(foreach w,$(T),$(findstring $(w),$(f)))),$(f))),$(PANEL_SUITES))

## panel-figures: updates a second and CPU time of the page with 1, 18 and 50 servos (2 min), in build/panel-figures.tsv
.PHONY: panel-figures
panel-figures: $(PANEL_NEEDS)
	@scripts/deps.sh panel-test
	$(clear)
	@node panel/test/measure.js build/panel-figures.tsv

## panel-pictures: pictures of each view of the control panel, light and dark, in build/panel-pictures (2 min)
.PHONY: panel-pictures
panel-pictures: $(PANEL_NEEDS)
	@scripts/deps.sh panel-test
	$(clear)
	@node panel/test/pictures.js build/panel-pictures
	$(call built,build/panel-pictures)

# `make test` also runs the suites of the panel if chromium-headless-shell is installed. PANEL=no leaves them out.
PANEL ?= $(if $(wildcard /usr/bin/chromium-headless-shell),yes,no)
