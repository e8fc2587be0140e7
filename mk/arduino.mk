# The Arduino library: a ZIP for the Arduino IDE (docs/arduino.md).

VERSION := $(shell sed -n 's/^.define CDS_VERSION "\(.*\)"/\1/p' include/cds55xx/version.h)

# $(1): folder. Returns the files below it.
below = $(shell find $(1) -type f)

build/arduino/CDS55xx-$(VERSION).zip: scripts/arduino.py LICENSE $(call below,arduino include src/core src/avr \
		boards/arduino-mega boards/arduino-uno)
	$(call say,ZIP,$@)
	$(Q)scripts/arduino.py $@

## arduino: build/arduino/CDS55xx-VERSION.zip, a library for the Arduino IDE
.PHONY: arduino
arduino: build/arduino/CDS55xx-$(VERSION).zip
