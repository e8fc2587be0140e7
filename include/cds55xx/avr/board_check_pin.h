/* SPDX-License-Identifier: MIT */
/* Checks port and bit of one pin. board_check_bus.h defines CDS_AVR_CHECK_KEY, as in _RXD, and
 * includes this file once for each pin: so there is no include guard. */
#ifdef CDS_AVR_CHECK_KEY

// clang-format off
#define CDS_AVR_CHECK_NO_PIN_ERROR                                                                 \
    CDS_AVR_CHECK_ERROR(board.h: CDS_AVR_CHECK_OF_PIN() is on \
                        CDS_AVR_CHECK_PIN_TEXT(CDS_AVR_CHECK_KEY); use a port of \
                        __AVR_DEVICE_NAME__, a capital letter, and a bit from 0 to 7)

#if CDS_AVR_CHECK_IS_MISSING(CDS_AVR_CHECK_BUS, CDS_AVR_CHECK_KEY, _PORT)
CDS_AVR_CHECK_ERROR(board.h: CDS_AVR_CHECK_OF_PIN()_PORT is missing; write the letter of a port)
#include CDS_AVR_CHECK_STOP
#elif CDS_AVR_CHECK_IS_MISSING(CDS_AVR_CHECK_BUS, CDS_AVR_CHECK_KEY, _BIT)
CDS_AVR_CHECK_ERROR(board.h: CDS_AVR_CHECK_OF_PIN()_BIT is missing; write a bit from 0 to 7)
#include CDS_AVR_CHECK_STOP
#elif CDS_AVR_CHECK_IS_PAREN(CDS_AVR_CHECK_OF_PIN(_PORT)) /* avr/io.h: PORTC is (*(...)(0x15)) */
CDS_AVR_CHECK_ERROR(board.h: CDS_AVR_CHECK_OF_PIN()_PORT is a register, or between parentheses;
                    write the letter of the port alone)
#include CDS_AVR_CHECK_STOP
#elif CDS_AVR_CHECK_IS_PAREN(CDS_AVR_CHECK_OF_PIN(_BIT))
CDS_AVR_CHECK_ERROR(board.h: CDS_AVR_CHECK_OF_PIN()_BIT is a register, or between parentheses;
                    write a bit from 0 to 7)
#include CDS_AVR_CHECK_STOP
#elif CDS_AVR_CHECK_OF_PIN(_PORT) /* D is a name, so 0; 'D' is 68 */
CDS_AVR_CHECK_NO_PIN_ERROR
#include CDS_AVR_CHECK_STOP
#elif CDS_AVR_CHECK_PORT(CDS_AVR_CHECK_BUS, CDS_AVR_CHECK_KEY) && \
    CDS_AVR_CHECK_BIT(CDS_AVR_CHECK_BUS, CDS_AVR_CHECK_KEY)
#else
CDS_AVR_CHECK_NO_PIN_ERROR
#include CDS_AVR_CHECK_STOP
#endif

/* Port G has fewer than 8 pins on every chip that has it, port C on some: avr/io.h defines those
 * that there are. */
#if CDS_AVR_CHECK_HAS_PIN(CDS_AVR_CHECK_OF_PIN(_PORT), CDS_AVR_CHECK_OF_PIN(_BIT))
#else
CDS_AVR_CHECK_ERROR(board.h: CDS_AVR_CHECK_OF_PIN() is on
                    CDS_AVR_CHECK_PIN_TEXT(CDS_AVR_CHECK_KEY), but that port of
                    __AVR_DEVICE_NAME__ has no pin of this number; use another pin)
#include CDS_AVR_CHECK_STOP
#endif
// clang-format on

#undef CDS_AVR_CHECK_NO_PIN_ERROR
#undef CDS_AVR_CHECK_KEY
#endif
