# SPDX-License-Identifier: MIT
# A release: what others use without this tree.

# Firmware of each board and profile, as FILE:NAME.
RELEASE_FIRMWARE := $(foreach b,$(BOARDS),$(foreach e,$(call profile_elfs,$(b)),$(foreach f,$(e) $(e:.elf=.hex),$(f):$(b)-$(notdir $(f)))))
# The library for each chip.
RELEASE_LIBRARIES := $(foreach m,$(MCUS),$(call library_of,$(m)):lib-$(m).a)
RELEASE_ARDUINO = $(ARDUINO_ZIP):arduino.zip
# The firmware contains parts of avr-libc (docs/licence.md).
RELEASE_LICENCES := LICENSE:LICENSE /usr/share/doc/avr-libc/copyright:LICENSE-avr-libc
RELEASED = $(RELEASE_FIRMWARE) $(RELEASE_LIBRARIES) $(RELEASE_ARDUINO) build/panel.zip:panel.zip $(RELEASE_LICENCES)
RELEASE_NEEDS = $(foreach f,$(RELEASED),$(firstword $(subst :, ,$(f))))

## release: firmware, libraries, Arduino ZIP, sources of the last commit and SHA256SUMS, in build/release
.PHONY: release
release: may-release $(PANEL_MODULES) $$(RELEASE_NEEDS)
	$(clear)
	@scripts/release.py build/release cds55xx-$(VERSION) $(RELEASED)

# Runs before the build and before npm, which take longer.
.PHONY: may-release
may-release:
	@scripts/release.py --check
