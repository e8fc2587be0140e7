/* SPDX-License-Identifier: MIT */
/* What a program on an AVR needs besides <cds55xx/...>: one macro binds a USART to a bus of the
 * program's, one starts the clock. All other interrupt vectors stay the program's own.
 *
 *     static struct cds_bus bus;
 *     CDS_AVR_BUS(bus, 0)
 *     CDS_AVR_CLOCK()
 *
 * The handlers know their bus and their registers at compile time: a second bus costs RAM, not
 * cycles. The program calls cds_avr_clock_open() and sei() before it opens the bus.
 *
 * Other handlers of the program hold up those of the bus. At 1 Mbps they may hold interrupts off
 * for 285 cycles at a time, entry and reti counted, before a byte is lost. A reply is lost when the
 * transmit-complete handler waits longer than the servo's return delay, register 0x05 x 32 cycles:
 * raise that register, or begin longer handlers with ISR_NOBLOCK. The handlers of other buses are
 * among them: with three buses busy at once, 5 (10 us) is enough.
 *
 * The handlers change the enables. Change other pins of those ports by a constant bit each (sbi,
 * cbi) or with interrupts off, or an enable may be put back to where it was.
 */
#ifndef CDS_AVR_H
#define CDS_AVR_H

#ifndef __OPTIMIZE__
#error "compile with -Os: the handlers must be inlined to keep up with 1 Mbps"
#endif

#include <avr/interrupt.h>

#include "cds55xx/link.h"         // the events
#include "cds55xx/avr/clock.h"    // cds_avr_clock_open()
#include "cds55xx/avr/handlers.h" // CDS_AVR_HANDLERS_*
#include "cds55xx/avr/usart.h"    // the verbs, inline

/* Binds bus `number` (0 to BOARD_BUS_COUNT - 1, a plain number) of the board to `bus`, a struct
 * cds_bus with static storage. At file scope, once for each bus.
 *
 * A servo may answer 32 cycles after the last stop bit: so the transmit-complete handler turns the
 * line around before anything is saved. */
#define CDS_AVR_BUS(bus, number)                                                                   \
    CDS_AVR_PASTE(CDS_AVR_HANDLERS_, CDS_AVR_BOARD(number, _WIRING))(bus, number)

/* Binds the board's BOARD_CLOCK_TIMER: its count, its overflow vector, and of its compare units A,
 * B and C one for each bus. Defines the functions through which the library reaches clock and
 * USARTs of this board. At file scope, once in a program. */
#define CDS_AVR_CLOCK() CDS_AVR_USART_FUNCTIONS_ CDS_AVR_CLOCK_FUNCTIONS_

/* Both for the only robot (cds55xx/robot.h) of a program: binds bus `number` to its bus, and the
 * clock. At file scope. */
#define CDS_AVR_ROBOT(robot, number)                                                               \
    CDS_AVR_BUS((robot).bus, number)                                                               \
    CDS_AVR_CLOCK()

#endif
