# SPDX-License-Identifier: MIT
# make install, uninstall and dist.

PREFIX ?= /usr/local

# Options that a program needs beside -mmcu. The handlers must be inlined, so the library refuses a program
# without optimisation (-O0). -flto: the compiler sees library and program at once.
INSTALLED_CFLAGS := -DF_CPU=16000000UL -Os -flto -ffunction-sections -fdata-sections -mstrict-X
INSTALLED_LDFLAGS := -Os -flto -flto-partition=none -Wl,--gc-sections -Wl,--relax
INSTALL := scripts/install.py

## install: library for each chip (MCUS=), simulator, man page; pkg-config and CMake (PREFIX= DESTDIR=)
.PHONY: install
install: may-install libs sim
	@$(INSTALL) install --prefix '$(PREFIX)' --destdir '$(DESTDIR)' --mcus '$(sort $(MCUS))' \
	  --cflags '$(INSTALLED_CFLAGS)' --ldflags '$(INSTALLED_LDFLAGS)'

# Before the build, which takes longer.
.PHONY: may-install
may-install:
	@$(INSTALL) check --prefix '$(PREFIX)' --destdir '$(DESTDIR)'

## uninstall: remove what make install has put into PREFIX
.PHONY: uninstall
uninstall:
	@$(INSTALL) uninstall --prefix '$(PREFIX)' --destdir '$(DESTDIR)'

## dist: build/cds55xx-<version>.tar.gz, the sources of the last commit
.PHONY: dist
dist: ARCHIVE = build/cds55xx-$(VERSION).tar.gz
dist:
	@git rev-parse -q --verify HEAD:./Makefile > /dev/null || { echo 'make dist needs a clone with git whose last commit has' \
	  'these sources: it archives that commit'; exit 1; }
	@command -v gzip > /dev/null || { echo 'make dist needs gzip; Debian: apt-get install gzip'; exit 1; }
	@git diff --quiet HEAD || echo 'note: what is not committed is not in the archive'
	@mkdir -p build
# No pipe: a shell tells the status of its last command only. An earlier archive stays until the new one is complete.
	$(Q)why=$$({ git archive --prefix=cds55xx-$(VERSION)/ HEAD > build/dist.tar && \
	  gzip -9n < build/dist.tar > build/dist.tar.gz && mv build/dist.tar.gz $(ARCHIVE); } 2>&1) || \
	  { rm -f build/dist.tar build/dist.tar.gz; echo '$(ARCHIVE) is not written: mend this, and repeat:' $$why; exit 1; }
	@rm build/dist.tar
	@echo $(ARCHIVE)
