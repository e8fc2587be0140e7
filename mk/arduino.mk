# The Arduino library: a ZIP for the Arduino IDE (docs/arduino.md).

ARDUINO_ZIP = build/arduino/CDS55xx-$(shell scripts/arduino.py --version).zip

# Packed each time: the same sources give the same bytes, in a fraction of a second.
build/arduino/CDS55xx-%.zip: force | tools
	$(call say,ZIP,$@)
	$(Q)scripts/arduino.py $@

## arduino: build/arduino/CDS55xx-VERSION.zip, a library for the Arduino IDE
.PHONY: arduino
arduino: $$(ARDUINO_ZIP)
