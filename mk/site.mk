# SPDX-License-Identifier: MIT
# The site: API reference and documents as HTML.

## site: API reference and documents as HTML, in build/site; fails if a public item is not documented
.PHONY: site
site:
	@scripts/deps.sh site
	$(call say,DOXYGEN,build/site)
	$(Q)rm -rf build/site && mkdir -p build/site
	$(Q)VERSION=$(VERSION) doxygen mk/Doxyfile
	@scripts/site.py build/site
	$(call built,build/site/index.html)
