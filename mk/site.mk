# The site: the API reference and all documents as HTML.

VERSION = $(shell sed -n 's/^\#define CDS_VERSION "\(.*\)"/\1/p' include/cds55xx/version.h)

## site: API reference and documents as HTML, in build/site; fails if a public item is not documented
.PHONY: site
site:
	@scripts/deps.sh site
	$(call say,DOXYGEN,build/site)
	$(Q)rm -rf build/site && mkdir -p build/site
	$(Q)VERSION=$(VERSION) doxygen mk/Doxyfile
	@scripts/site.py build/site
	$(call built,build/site/index.html)
