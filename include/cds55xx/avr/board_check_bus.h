/* SPDX-License-Identifier: MIT */
/* The checks of one bus. board_check.h defines its number, CDS_AVR_CHECK_BUS, and includes this
 * file once for each bus: so there is no include guard. No check follows the first mistake.
 *
 * A value like 'D' cannot be pasted: the preprocessor reports it, and takes the condition for
 * false. So each condition says what is right, and the error stands behind #else. */
#ifdef CDS_AVR_CHECK_BUS

// clang-format off

#ifndef CDS_AVR_CHECK_FAILED
#if CDS_AVR_CHECK_PASTE(CDS_AVR_CHECK_USART_, CDS_AVR_CHECK_VALUE(_USART))
#else
#define CDS_AVR_CHECK_FAILED
CDS_AVR_CHECK_ERROR(board.h: bus CDS_AVR_CHECK_BUS has USART CDS_AVR_CHECK_VALUE(_USART), but
                    __AVR_DEVICE_NAME__ has no USART of this number; is this the board.h of another chip?)
#endif
#endif

#ifndef CDS_AVR_CHECK_FAILED
#if CDS_AVR_CHECK_WIRING
#else
#define CDS_AVR_CHECK_FAILED
CDS_AVR_CHECK_ERROR(board.h: the wiring of bus CDS_AVR_CHECK_BUS is CDS_AVR_CHECK_VALUE(_WIRING);
                    use TWO_ENABLES, ONE_ENABLE, TIED, ADAPTER or ADAPTER_ECHO)
#endif
#endif

/* Values of the pins. */
#ifndef CDS_AVR_CHECK_FAILED
#if CDS_AVR_CHECK_IS_PIN(RXD)
#else
#define CDS_AVR_CHECK_FAILED
CDS_AVR_CHECK_NO_PIN_ERROR(RXD)
#endif
#endif

#ifndef CDS_AVR_CHECK_FAILED
#if CDS_AVR_CHECK_IS_PIN(TXD)
#else
#define CDS_AVR_CHECK_FAILED
CDS_AVR_CHECK_NO_PIN_ERROR(TXD)
#endif
#endif

#if !defined CDS_AVR_CHECK_FAILED && CDS_AVR_CHECK_WIRING == CDS_AVR_CHECK_WIRING_TWO_ENABLES
#if CDS_AVR_CHECK_IS_PIN(TX_ENABLE)
#else
#define CDS_AVR_CHECK_FAILED
CDS_AVR_CHECK_NO_PIN_ERROR(TX_ENABLE)
#endif
#endif

#if !defined CDS_AVR_CHECK_FAILED && CDS_AVR_CHECK_WIRING == CDS_AVR_CHECK_WIRING_TWO_ENABLES
#if CDS_AVR_CHECK_IS_PIN(RX_ENABLE)
#else
#define CDS_AVR_CHECK_FAILED
CDS_AVR_CHECK_NO_PIN_ERROR(RX_ENABLE)
#endif
#endif

#if !defined CDS_AVR_CHECK_FAILED && CDS_AVR_CHECK_WIRING == CDS_AVR_CHECK_WIRING_ONE_ENABLE
#if CDS_AVR_CHECK_IS_PIN(ENABLE)
#else
#define CDS_AVR_CHECK_FAILED
CDS_AVR_CHECK_NO_PIN_ERROR(ENABLE)
#endif
#endif

/* RXD and TXD are the pins of the USART. */
#if !defined CDS_AVR_CHECK_FAILED && defined CDS_AVR_USART_PINS_KNOWN
#if CDS_AVR_CHECK_PIN(RXD) != CDS_AVR_CHECK_USART_PIN(RXD) ||                                      \
    CDS_AVR_CHECK_PIN(TXD) != CDS_AVR_CHECK_USART_PIN(TXD)
#define CDS_AVR_CHECK_FAILED
CDS_AVR_CHECK_ERROR(board.h: bus CDS_AVR_CHECK_BUS has RXD on CDS_AVR_CHECK_PIN_TEXT(RXD) and TXD
                    on CDS_AVR_CHECK_PIN_TEXT(TXD); USART CDS_AVR_CHECK_VALUE(_USART) of
                    __AVR_DEVICE_NAME__ has RXD on CDS_AVR_CHECK_USART_PIN_TEXT(RXD) and TXD on
                    CDS_AVR_CHECK_USART_PIN_TEXT(TXD))
#endif
#endif

/* An enable has a pin of its own. */
#if !defined CDS_AVR_CHECK_FAILED && CDS_AVR_CHECK_WIRING == CDS_AVR_CHECK_WIRING_TWO_ENABLES
#if CDS_AVR_CHECK_PIN(TX_ENABLE) == CDS_AVR_CHECK_PIN(RXD)
#define CDS_AVR_CHECK_FAILED
CDS_AVR_CHECK_SAME_PIN_ERROR(TX_ENABLE, RXD)
#elif CDS_AVR_CHECK_PIN(TX_ENABLE) == CDS_AVR_CHECK_PIN(TXD)
#define CDS_AVR_CHECK_FAILED
CDS_AVR_CHECK_SAME_PIN_ERROR(TX_ENABLE, TXD)
#elif CDS_AVR_CHECK_PIN(RX_ENABLE) == CDS_AVR_CHECK_PIN(RXD)
#define CDS_AVR_CHECK_FAILED
CDS_AVR_CHECK_SAME_PIN_ERROR(RX_ENABLE, RXD)
#elif CDS_AVR_CHECK_PIN(RX_ENABLE) == CDS_AVR_CHECK_PIN(TXD)
#define CDS_AVR_CHECK_FAILED
CDS_AVR_CHECK_SAME_PIN_ERROR(RX_ENABLE, TXD)
#elif CDS_AVR_CHECK_PIN(TX_ENABLE) == CDS_AVR_CHECK_PIN(RX_ENABLE)
#define CDS_AVR_CHECK_FAILED
CDS_AVR_CHECK_ERROR(board.h: CDS_AVR_CHECK_VALUE(_TX_ENABLE) and CDS_AVR_CHECK_VALUE(_RX_ENABLE)
                    are both on CDS_AVR_CHECK_PIN_TEXT(TX_ENABLE); use two pins, or the wiring ONE_ENABLE)
#endif
#endif

#if !defined CDS_AVR_CHECK_FAILED && CDS_AVR_CHECK_WIRING == CDS_AVR_CHECK_WIRING_ONE_ENABLE
#if CDS_AVR_CHECK_PIN(ENABLE) == CDS_AVR_CHECK_PIN(RXD)
#define CDS_AVR_CHECK_FAILED
CDS_AVR_CHECK_SAME_PIN_ERROR(ENABLE, RXD)
#elif CDS_AVR_CHECK_PIN(ENABLE) == CDS_AVR_CHECK_PIN(TXD)
#define CDS_AVR_CHECK_FAILED
CDS_AVR_CHECK_SAME_PIN_ERROR(ENABLE, TXD)
#endif
#endif

// clang-format on
#undef CDS_AVR_CHECK_BUS
#endif
