/* SPDX-License-Identifier: MIT */
/* A file that uses the core's object of the bus's USART without CDS55xx.h ends as "multiple
 * definition of __vector_18". A section .gnu.warning.X lets the linker print a text for each use of
 * the symbol X. */
#include "serial_notice.h"

    .global cds55xx_serial_notice ; begin() refers to it, so the linker takes this file
    .set cds55xx_serial_notice, 0
#if BOARD_BUS0_USART == 0
    .section .gnu.warning.Serial
#else
    .section .gnu.warning.Serial1
#endif
    .ascii CDS55XX_SERIAL_NOTICE
    .byte 0
