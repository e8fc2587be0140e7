/* SPDX-License-Identifier: MIT */
/* Where constant tables stand: an AVR keeps them in flash only if told so (Harvard memory), by the
 * named address space __flash of C; elsewhere the word means nothing. */
#ifndef CDS_FLASH_H
#define CDS_FLASH_H

#ifdef __FLASH
#define CDS_FLASH __flash
#else
#define CDS_FLASH
#endif

#endif
