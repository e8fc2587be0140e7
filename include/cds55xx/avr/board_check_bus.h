/* SPDX-License-Identifier: MIT */
/* Checks the values of one bus. board_check.h defines its number, CDS_AVR_CHECK_BUS, and includes
 * this file once for each bus: so there is no include guard.
 *
 * Each check tests for the right value and reports in #else: if a value cannot be pasted, the
 * preprocessor takes the condition for false, and the error with the right values is still
 * printed.
 *
 * system_header: else GCC 7 and later warn of a `defined` that comes from a macro, here and in
 * board_check_pin.h. */
#ifdef CDS_AVR_CHECK_BUS
#pragma GCC system_header

// clang-format off
#if CDS_AVR_CHECK_IS_MISSING(CDS_AVR_CHECK_BUS, _USART, )
CDS_AVR_CHECK_ERROR(board.h: CDS_AVR_CHECK_OF_BUS()_USART is missing; write the number of a USART)
#include CDS_AVR_CHECK_STOP
#elif CDS_AVR_CHECK_KNOWN(USART, CDS_AVR_CHECK_OF_BUS(_USART))
#else
CDS_AVR_CHECK_ERROR(board.h: bus CDS_AVR_CHECK_BUS has USART CDS_AVR_CHECK_OF_BUS(_USART), but
                    __AVR_DEVICE_NAME__ has no USART of this number;
                    is this the board.h of another chip?)
#include CDS_AVR_CHECK_STOP
#endif

#if CDS_AVR_CHECK_IS_EMPTY(CDS_AVR_CHECK_OF_BUS(_WIRING))
CDS_AVR_CHECK_ERROR(board.h: CDS_AVR_CHECK_OF_BUS()_WIRING has no value; use CDS_AVR_CHECK_WIRINGS)
#include CDS_AVR_CHECK_STOP
#elif CDS_AVR_CHECK_WIRING(CDS_AVR_CHECK_BUS)
#else
CDS_AVR_CHECK_ERROR(board.h: the wiring of bus CDS_AVR_CHECK_BUS is CDS_AVR_CHECK_OF_BUS(_WIRING);
                    use CDS_AVR_CHECK_WIRINGS)
#include CDS_AVR_CHECK_STOP
#endif

#define CDS_AVR_CHECK_KEY _RXD
#include "cds55xx/avr/board_check_pin.h"
#define CDS_AVR_CHECK_KEY _TXD
#include "cds55xx/avr/board_check_pin.h"
#if CDS_AVR_CHECK_WIRING(CDS_AVR_CHECK_BUS) == CDS_AVR_CHECK_WIRING_TWO_ENABLES
#define CDS_AVR_CHECK_KEY _TX_ENABLE
#include "cds55xx/avr/board_check_pin.h"
#define CDS_AVR_CHECK_KEY _RX_ENABLE
#include "cds55xx/avr/board_check_pin.h"
#elif CDS_AVR_CHECK_WIRING(CDS_AVR_CHECK_BUS) == CDS_AVR_CHECK_WIRING_ONE_ENABLE
#define CDS_AVR_CHECK_KEY _ENABLE
#include "cds55xx/avr/board_check_pin.h"
#endif

/* RXD and TXD are the pins of the USART. */
#if defined CDS_AVR_USART_PINS_KNOWN &&                                                            \
    (CDS_AVR_CHECK_PIN(CDS_AVR_CHECK_BUS, _RXD) !=                                                 \
         CDS_AVR_CHECK_USART_PIN(CDS_AVR_CHECK_OF_BUS(_USART), _RXD) ||                            \
     CDS_AVR_CHECK_PIN(CDS_AVR_CHECK_BUS, _TXD) !=                                                 \
         CDS_AVR_CHECK_USART_PIN(CDS_AVR_CHECK_OF_BUS(_USART), _TXD))
CDS_AVR_CHECK_ERROR(board.h: bus CDS_AVR_CHECK_BUS has RXD on CDS_AVR_CHECK_PIN_TEXT(_RXD) and TXD
                    on CDS_AVR_CHECK_PIN_TEXT(_TXD); USART CDS_AVR_CHECK_OF_BUS(_USART) of
                    __AVR_DEVICE_NAME__ has RXD on CDS_AVR_CHECK_USART_PIN_TEXT(_RXD) and TXD on
                    CDS_AVR_CHECK_USART_PIN_TEXT(_TXD))
#include CDS_AVR_CHECK_STOP
#endif
// clang-format on

#undef CDS_AVR_CHECK_BUS
#endif
