/* SPDX-License-Identifier: MIT */
/* The version of library and firmware. */
#ifndef CDS_VERSION_H
#define CDS_VERSION_H

/* As text: major.minor.patch. */
#define CDS_VERSION "0.1.0"

#endif
