# SPDX-License-Identifier: MIT
# The Arduino library: a ZIP for the Arduino IDE (docs/arduino.md).

ARDUINO_ZIP = build/arduino/CDS55xx-$(VERSION).zip

# Packed each time: the same sources give the same bytes, in a fraction of a second.
$(ARDUINO_ZIP): force | tools
	$(call say,ZIP,$@)
	$(Q)scripts/arduino.py $@

## arduino: build/arduino/CDS55xx-VERSION.zip, a library for the Arduino IDE
.PHONY: arduino
arduino: $(ARDUINO_ZIP)
	$(call built,$^)
