# SPDX-License-Identifier: MIT
# What leaves the tree: the site (API reference and documents as HTML), and a release.

## site: API reference and documents as HTML, in build/site; fails if a public item is not documented
.PHONY: site
site:
	@scripts/deps.sh site
	$(call say,DOXYGEN,build/site)
	$(Q)rm -rf build/site && mkdir -p build/site
	$(Q)VERSION=$(VERSION) doxygen mk/Doxyfile
	@scripts/site.py build/site
	$(call built,build/site/index.html)

# ---- release ---------------------------------------------------------------------------------------

# Firmware of each board and profile, as FILE:NAME.
RELEASE_FIRMWARE := $(foreach b,$(BOARDS),$(foreach e,$(call profile_elfs,$(b)),$(foreach f,$(e) $(e:.elf=.hex),$(f):$(b)-$(notdir $(f)))))
# The library for each chip.
RELEASE_LIBRARIES := $(foreach m,$(MCUS),$(call library_of,$(m)):lib-$(m).a)
RELEASE_ARDUINO = $(if $(wildcard mk/arduino.mk),build/arduino/CDS55xx-$(VERSION).zip:arduino.zip)
# The firmware contains parts of avr-libc (docs/licence.md).
RELEASE_LICENCES := LICENSE:LICENSE /usr/share/doc/avr-libc/copyright:LICENSE-avr-libc
RELEASED = $(RELEASE_FIRMWARE) $(RELEASE_LIBRARIES) $(RELEASE_ARDUINO) build/panel.zip:panel.zip $(RELEASE_LICENCES)
RELEASE_NEEDS = $(foreach f,$(RELEASED),$(firstword $(subst :, ,$(f))))

## release: firmware, libraries, Arduino ZIP, sources of the last commit and SHA256SUMS, in build/release
.PHONY: release
release: $$(RELEASE_NEEDS)
	$(clear)
	@scripts/release.py build/release cds55xx-$(VERSION) $(RELEASED)
