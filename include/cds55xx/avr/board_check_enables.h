/* SPDX-License-Identifier: MIT */
/* Checks the enables of one bus: each has a pin of its own, on a port that sbi and cbi reach.
 * board_check.h defines the number of the bus, CDS_AVR_CHECK_BUS, and includes this file once for
 * each bus. The file then includes itself once for each enable, with CDS_AVR_CHECK_KEY: so there is
 * no include guard. */
#if defined CDS_AVR_CHECK_BUS && !defined CDS_AVR_CHECK_KEY

// clang-format off
#if CDS_AVR_CHECK_WIRING(CDS_AVR_CHECK_BUS) == CDS_AVR_CHECK_WIRING_TWO_ENABLES
#if CDS_AVR_CHECK_PIN(CDS_AVR_CHECK_BUS, _TX_ENABLE) == \
    CDS_AVR_CHECK_PIN(CDS_AVR_CHECK_BUS, _RX_ENABLE)
CDS_AVR_CHECK_ERROR(board.h: CDS_AVR_CHECK_OF_BUS(_TX_ENABLE) and
                    CDS_AVR_CHECK_OF_BUS(_RX_ENABLE) are both on
                    CDS_AVR_CHECK_PIN_TEXT(_TX_ENABLE); use two pins, or the wiring ONE_ENABLE)
#include CDS_AVR_CHECK_STOP
#endif
#define CDS_AVR_CHECK_KEY _TX_ENABLE
#include "cds55xx/avr/board_check_enables.h"
#define CDS_AVR_CHECK_KEY _RX_ENABLE
#include "cds55xx/avr/board_check_enables.h"
#elif CDS_AVR_CHECK_WIRING(CDS_AVR_CHECK_BUS) == CDS_AVR_CHECK_WIRING_ONE_ENABLE
#define CDS_AVR_CHECK_KEY _ENABLE
#include "cds55xx/avr/board_check_enables.h"
#endif
// clang-format on
#undef CDS_AVR_CHECK_BUS

#elif defined CDS_AVR_CHECK_KEY

// clang-format off
/* sbi and cbi reach addresses below 0x40. avr/io.h defines PORTD by these two macros; with these
 * definitions #if can compute its address. */
#pragma push_macro("_SFR_IO8")
#pragma push_macro("_SFR_MEM8")
#undef _SFR_IO8
#undef _SFR_MEM8
#define _SFR_IO8(address)  ((address) + 0x20)
#define _SFR_MEM8(address) (address)
#if CDS_AVR_CHECK_PASTE(PORT, CDS_AVR_CHECK_OF_PIN(_PORT)) < 0x40
#else
CDS_AVR_CHECK_ERROR(board.h: CDS_AVR_CHECK_OF_PIN() is on
                    CDS_AVR_CHECK_PIN_TEXT(CDS_AVR_CHECK_KEY);
                    use a port whose registers lie below 0x40, as A to E)
#include CDS_AVR_CHECK_STOP
#endif
#pragma pop_macro("_SFR_IO8")
#pragma pop_macro("_SFR_MEM8")

#define CDS_AVR_CHECK_IS_ON(pin) (CDS_AVR_CHECK_PIN(CDS_AVR_CHECK_BUS, CDS_AVR_CHECK_KEY) == (pin))
#if CDS_AVR_CHECK_IS_ON(CDS_AVR_CHECK_PIN(0, _RXD))
#define CDS_AVR_CHECK_OWNER BOARD_BUS0_RXD
#elif CDS_AVR_CHECK_IS_ON(CDS_AVR_CHECK_PIN(0, _TXD))
#define CDS_AVR_CHECK_OWNER BOARD_BUS0_TXD
#elif BOARD_BUS_COUNT > 1 && CDS_AVR_CHECK_IS_ON(CDS_AVR_CHECK_PIN(1, _RXD))
#define CDS_AVR_CHECK_OWNER BOARD_BUS1_RXD
#elif BOARD_BUS_COUNT > 1 && CDS_AVR_CHECK_IS_ON(CDS_AVR_CHECK_PIN(1, _TXD))
#define CDS_AVR_CHECK_OWNER BOARD_BUS1_TXD
#elif BOARD_BUS_COUNT > 2 && CDS_AVR_CHECK_IS_ON(CDS_AVR_CHECK_PIN(2, _RXD))
#define CDS_AVR_CHECK_OWNER BOARD_BUS2_RXD
#elif BOARD_BUS_COUNT > 2 && CDS_AVR_CHECK_IS_ON(CDS_AVR_CHECK_PIN(2, _TXD))
#define CDS_AVR_CHECK_OWNER BOARD_BUS2_TXD
#elif CDS_AVR_CHECK_BUS > 0 && CDS_AVR_CHECK_WIRING(0) == CDS_AVR_CHECK_WIRING_TWO_ENABLES && \
    CDS_AVR_CHECK_IS_ON(CDS_AVR_CHECK_PIN(0, _TX_ENABLE))
#define CDS_AVR_CHECK_OWNER BOARD_BUS0_TX_ENABLE
#elif CDS_AVR_CHECK_BUS > 0 && CDS_AVR_CHECK_WIRING(0) == CDS_AVR_CHECK_WIRING_TWO_ENABLES && \
    CDS_AVR_CHECK_IS_ON(CDS_AVR_CHECK_PIN(0, _RX_ENABLE))
#define CDS_AVR_CHECK_OWNER BOARD_BUS0_RX_ENABLE
#elif CDS_AVR_CHECK_BUS > 0 && CDS_AVR_CHECK_WIRING(0) == CDS_AVR_CHECK_WIRING_ONE_ENABLE && \
    CDS_AVR_CHECK_IS_ON(CDS_AVR_CHECK_PIN(0, _ENABLE))
#define CDS_AVR_CHECK_OWNER BOARD_BUS0_ENABLE
#elif CDS_AVR_CHECK_BUS > 1 && CDS_AVR_CHECK_WIRING(1) == CDS_AVR_CHECK_WIRING_TWO_ENABLES && \
    CDS_AVR_CHECK_IS_ON(CDS_AVR_CHECK_PIN(1, _TX_ENABLE))
#define CDS_AVR_CHECK_OWNER BOARD_BUS1_TX_ENABLE
#elif CDS_AVR_CHECK_BUS > 1 && CDS_AVR_CHECK_WIRING(1) == CDS_AVR_CHECK_WIRING_TWO_ENABLES && \
    CDS_AVR_CHECK_IS_ON(CDS_AVR_CHECK_PIN(1, _RX_ENABLE))
#define CDS_AVR_CHECK_OWNER BOARD_BUS1_RX_ENABLE
#elif CDS_AVR_CHECK_BUS > 1 && CDS_AVR_CHECK_WIRING(1) == CDS_AVR_CHECK_WIRING_ONE_ENABLE && \
    CDS_AVR_CHECK_IS_ON(CDS_AVR_CHECK_PIN(1, _ENABLE))
#define CDS_AVR_CHECK_OWNER BOARD_BUS1_ENABLE
#elif defined BOARD_HOST_USART && defined CDS_AVR_USART_PINS_KNOWN && \
    CDS_AVR_CHECK_IS_ON(CDS_AVR_CHECK_USART_PIN(BOARD_HOST_USART, _RXD))
#define CDS_AVR_CHECK_OWNER RXD of the host link
#elif defined BOARD_HOST_USART && defined CDS_AVR_USART_PINS_KNOWN && \
    CDS_AVR_CHECK_IS_ON(CDS_AVR_CHECK_USART_PIN(BOARD_HOST_USART, _TXD))
#define CDS_AVR_CHECK_OWNER TXD of the host link
#endif
#ifdef CDS_AVR_CHECK_OWNER
CDS_AVR_CHECK_ERROR(board.h: CDS_AVR_CHECK_OF_PIN() is on
                    CDS_AVR_CHECK_PIN_TEXT(CDS_AVR_CHECK_KEY),
                    the pin of CDS_AVR_CHECK_OWNER; use another pin)
#include CDS_AVR_CHECK_STOP
#endif
// clang-format on

#undef CDS_AVR_CHECK_IS_ON
#undef CDS_AVR_CHECK_KEY
#endif
